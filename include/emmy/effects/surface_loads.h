#ifndef emmy_effects_surface_loads_h
#define emmy_effects_surface_loads_h

#include <deal.II/base/function_parser.h>

#include <emmy/effects/amplitude.h>
#include <emmy/effects/corner_forces.h>

namespace emmy
{
  /** One load: where it acts and what it is. */
  template <int dim>
  struct SurfaceLoadChoice
  {
    /** Of the load, and its own. */
    std::string section, name;
    /** Where the box's faces look, 2 d or 2 d + 1; none: all of them. */
    unsigned int side = whole;
    /** Positive where the particles are whose faces it may be; null: all. */
    std::shared_ptr<const dealii::FunctionParser<dim>> region;
    /** Over time; null: constant. */
    std::shared_ptr<const Amplitude> amplitude;
    /** Whether the load turns with the body. */
    bool                   follows = false;
    dealii::Tensor<1, dim> traction;      ///< Pa of the undeformed face
    double                 pressure = 0.; ///< Pa

    /** No step within the boxes: the whole surface. */
    static constexpr unsigned int whole = static_cast<unsigned int>(-1);
  };

  /**
   * Faces of particles' boxes that a load acts on, as bits of a scalar field:
   * bit 2 d + 1 is the face whose normal was +x_d. In each row of particles
   * along the normal the last one in the region has a face; with no side all
   * faces of all particles count, and what two share cancels: the surface of
   * the body.
   */
  template <int dim>
  class LoadedFaces
  {
  public:
    /** A face of an undeformed box. */
    struct Face
    {
      dealii::Tensor<1, dim> arm;  ///< from the box's centre, m
      dealii::Tensor<1, dim> area; ///< along its normal, m^(dim-1)
    };

    /** Where a particle's numbers are. */
    struct Fields
    {
      /** Body, F, and which faces are loaded. */
      unsigned int body, deformation_gradient, faces;
    };

    /** Finds the loaded faces of particles. */
    LoadedFaces(const Fields                                 &fields,
                std::shared_ptr<const SurfaceLoadChoice<dim>> choice,
                const std::vector<dealii::Tensor<1, dim>> &half_length_of_body);

    /** As Effect::mark(). */
    std::string
    mark(const BackgroundGrid<dim>               &grid,
         dealii::Particles::ParticleHandler<dim> &particles) const;

    /** Those of a point that are loaded. */
    std::vector<Face>
    of(const PointArrays<dim> &points, const std::size_t p) const;

    /** Where a particle's numbers are. */
    const Fields fields;
    /** Which surfaces. */
    const std::shared_ptr<const SurfaceLoadChoice<dim>> choice;
    /** At the start, m, by body. */
    const std::vector<dealii::Tensor<1, dim>> half_length_of_body;

  private:
    bool
    may_hold(const dealii::Particles::ParticleAccessor<dim> &particle) const;
    /** The number of a particle's row, by the lattice of its body. */
    std::array<long, dim>
    row_of(const dealii::Particles::ParticleAccessor<dim> &particle) const;
  };

  /**
   * A traction t on each square metre of the undeformed surface, whichever way
   * it turns: f_A = a sum (S_A + grad S_A . F xi) t A over the faces, with
   * xi the face's place in its undeformed box and F that of the start of the
   * step: as GIMP, tools and pressures keep it; else the unit tensor, and the
   * load acts half a spacing beside the turned face. Cost: a pass over the
   * points.
   */
  template <int dim>
  class Traction : public Effect<dim>, public Load<dim>
  {
  public:
    /** On these faces. */
    explicit Traction(LoadedFaces<dim> faces);

    std::string
    mark(const BackgroundGrid<dim>               &grid,
         dealii::Particles::ParticleHandler<dim> &particles) const override;
    const Load<dim> *
    load() const override
    {
      return this;
    }
    void
    add_load(const StepData<dim> &step,
             std::vector<double> &local_force) const override;
    void
    add_load_at_points(const StepData<dim> &step,
                       std::vector<double> &point_force) const override;

  private:
    const LoadedFaces<dim> faces;
  };

  /**
   * A pressure that stays normal to the surface as it turns and stretches. On
   * faces it is -p cof(F) N A, with F of the middle of the step. On a whole
   * body it is an equal stress in all its particles, whose work is -p times
   * what the body's volume gains, exactly: with j - 1 = D_j : A of the step, A
   * = dF^T dF - I,
   *
   *     f_A = -p sum V_p Z 2 D_j Z^T grad S_A   (geometry of the middle),
   *     f_A = -p sum V_p (I + H/2) 2 D_j grad S_A   (of the start).
   *
   * Cost: a pass over the points; for each that is loaded that of its
   * stiffness, and dim^2 evaluations more for the derivative.
   */
  template <int dim>
  class Pressure : public ForceTerm<dim>
  {
  public:
    /** On these faces. */
    explicit Pressure(LoadedFaces<dim> faces);

    std::string
    mark(const BackgroundGrid<dim>               &grid,
         dealii::Particles::ParticleHandler<dim> &particles) const override;
    std::string
    add(const StepData<dim> &step,
        const Iterate<dim>  &iterate,
        Vector              &force,
        Matrix              *jacobian) const override;
    std::vector<EnergyEntry>
    energies(const StepData<dim>    &step,
             const Vector           &displacement,
             const PointArrays<dim> &accepted) const override;
    std::vector<EnergyEntry>
    energy_entries() const override;

  private:
    /**
     * @param trial where the points keep F at t + dt; null: it is not wanted
     */
    void
    add_forces(const StepData<dim>       &step,
               const std::vector<double> &local_displacement,
               Vector                    &force,
               Matrix                    *jacobian,
               PointArrays<dim>          *trial) const;

    const LoadedFaces<dim> faces;
  };

  /** Section of a load, e.g. `Effects/Surface loads/footing`. */
  template <int dim>
  class SurfaceLoadParameters : public Section
  {
  public:
    /** One load, with its name. */
    SurfaceLoadParameters(const std::string &section, const std::string &name);

    /** Check and add; throws ExcParameter. */
    void
    add_to(Effects<dim> &effects, FieldLayout &layout) const;

    /** The particle field that marks its faces. */
    Field
    field() const;
    /** Pressure, else traction. */
    bool
    is_pressure() const;
    /** Of its amplitude. */
    TimeHistory
    history() const
    {
      return amplitude.history("surface load " + name, this->path());
    }

    const std::string name; ///< as in `Names`

  private:
    std::string         side = "all", region;
    std::vector<double> traction;
    double              pressure = 0.;
    AmplitudeParameters amplitude;
  };

  /** Section `Effects/Surface loads`. */
  template <int dim>
  class SurfaceLoadsParameters : public EffectParameters<dim>,
                                 public GivenOverTime
  {
  public:
    /** Declares the loads that `Names` lists. */
    explicit SurfaceLoadsParameters(const std::string &section);

    void
    declare_named(const ParameterFile &file) override;
    std::string
    one_of_each() const override;
    void
    add_to(Effects<dim> &effects, FieldLayout &layout) const override;

    /** What `emmy --check` says of it. */
    static EffectCard
    card();
    EffectCard
    card_in_scene(const EffectCard &of_library) const override;
    std::vector<TimeHistory>
    histories() const override;

  private:
    std::vector<std::string>                                 names;
    std::vector<std::unique_ptr<SurfaceLoadParameters<dim>>> loads;
  };
} // namespace emmy

#endif
