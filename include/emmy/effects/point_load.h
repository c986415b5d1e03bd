#ifndef emmy_effects_point_load_h
#define emmy_effects_point_load_h

#include <emmy/effects/field_load.h>

namespace emmy
{
  /**
   * Section `Effects/Point load`: a force that chosen particles share and
   * carry along for as long as the scene runs. Neumann data of the material
   * point method are concentrated at particles like this (Pretti et al. 2023,
   * section 3.3; the beam of their section 7.1).
   *
   * The particles are chosen by their initial positions: the nearest to each
   * of some positions, or all inside a region. What each holds is the scalar
   * field `point_load_share`; the shares of a scene add to one.
   */
  template <int dim>
  class PointLoadParameters : public EffectParameters<dim>, public GivenOverTime
  {
  public:
    /** Declares the entries of a section. */
    explicit PointLoadParameters(const std::string &section);

    void
    add_to(Effects<dim> &effects, FieldLayout &layout) const override;

    /** What `emmy --check` says of it. */
    static EffectCard
    card();
    std::vector<TimeHistory>
    histories() const override;

  private:
    /** Throws ExcParameter. */
    void
    validate() const;

    std::vector<double>             force;     // N
    std::vector<dealii::Point<dim>> positions; // m
    std::string                     region;
    AmplitudeParameters             amplitude;
  };

  /** A point load: f_A = a sum S_Ap s_p F with the shares s_p. */
  template <int dim>
  using PointLoad = FieldLoad<dim>;
} // namespace emmy

#endif
