#ifndef emmy_effects_added_mass_h
#define emmy_effects_added_mass_h

#include <emmy/system/active_grid.h>
#include <emmy/system/couplings.h>

#include <string>

namespace emmy
{
  /** A mass G of an effect's own, a part of M~. See Effect::added_mass(). */
  template <int dim>
  class AddedMass
  {
  public:
    virtual ~AddedMass() = default;

    /** Hand out G, block by block, with no damping. */
    virtual void
    hand_out(const ActiveGrid<dim> &active,
             const MassReceiver    &receive) const = 0;

    /** v . G v / 2, this rank's share, J. */
    virtual double
    kinetic_energy(const ActiveGrid<dim> &active,
                   const Vector          &velocity) const = 0;

    /**
     * The column of the ledger that has what G loses, Delta v . G Delta v / 2
     * in a step.
     */
    virtual std::string
    loss_column() const = 0;
  };
} // namespace emmy

#endif
