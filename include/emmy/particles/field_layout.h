#ifndef emmy_particles_field_layout_h
#define emmy_particles_field_layout_h

#include <emmy/base/field.h>

#include <string>
#include <vector>

namespace emmy
{
  /**
   * The fields of the particles of a scene: the union of what its effects ask
   * for, and nothing else. The values are the properties of deal.II's
   * particles, in this order. Position and id are not fields.
   */
  class FieldLayout
  {
  public:
    /** With the fields that every particle has. */
    explicit FieldLayout(const unsigned int dim);

    /** Book the fields that are asked for from now on to an effect. */
    void
    set_effect(const std::string &name);

    /**
     * Ask for a field; asking twice is the same as once.
     * @return the index of its first component.
     */
    unsigned int
    add(const Field &field);

    /** First component of a field that is there. */
    unsigned int
    operator[](const std::string &name) const;

    /** Whether somebody asked for it. */
    bool
    has(const std::string &name) const;

    /** All, in the order of their numbers. */
    const std::vector<Field> &
    fields() const;

    /** All components of an undisturbed particle. */
    std::vector<double>
    initial_values() const;

    /** Number of doubles per particle. */
    unsigned int
    n_components() const;

  private:
    const unsigned int dim;
    std::string        effect; ///< that asks now
    std::vector<Field> list;
  };

  /**
   * The fields of every scene: velocity, mass, reference volume, body.
   */
  FieldLayout
  basic_fields(const unsigned int dim);
} // namespace emmy

#endif
