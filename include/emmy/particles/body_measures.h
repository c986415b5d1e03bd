#ifndef emmy_particles_body_measures_h
#define emmy_particles_body_measures_h

#include <emmy/particles/body.h>

#include <string>
#include <vector>

namespace emmy
{
  /** What the particles of a body amount to at the start. */
  template <int dim>
  struct BodyMeasures
  {
    double             volume = 0.; ///< m^3, m^2 in plane strain
    double             mass   = 0.; ///< kg
    dealii::Point<dim> center;      ///< of mass, m
    /** Corners of the particles' boxes, m. */
    dealii::Point<dim> lower, upper;
    unsigned int       pieces = 0; ///< see count_pieces()
    /** Of a shape that does not know it: from samples, see sampled_volume(). */
    double shape_volume = 0.;
  };

  /**
   * Volume of a shape, m^3, from 2^18 points that fill its bounding box evenly
   * (Sobol's sequence), of which each rank takes its share: right to about
   * 0.1 % of the box. 0 if it has no box. Collective.
   */
  template <int dim>
  double
  sampled_volume(const Shape<dim> &shape, const MPI_Comm communicator);

  /** Those of all bodies, right after fill(). Collective. */
  template <int dim>
  std::vector<BodyMeasures<dim>>
  measure_bodies(const std::vector<Body<dim>>                  &bodies,
                 const BackgroundGrid<dim>                     &grid,
                 const FieldLayout                             &layout,
                 const dealii::Particles::ParticleHandler<dim> &particles);

  /**
   * Lines for the head of a run: volume, mass, extent and centre of the
   * particles, and their pieces; and a note for each that is more than 1 % of
   * the exact value, or of a cell, away from that of the shape as far as it is
   * known.
   */
  template <int dim>
  std::vector<std::string>
  describe_measures(const Body<dim>           &body,
                    const BodyMeasures<dim>   &measures,
                    const BackgroundGrid<dim> &grid);
} // namespace emmy

#endif
