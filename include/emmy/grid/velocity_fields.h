#ifndef emmy_grid_velocity_fields_h
#define emmy_grid_velocity_fields_h

#include <deal.II/base/index_set.h>

#include <algorithm>
#include <vector>

namespace emmy
{
  /**
   * The velocity fields that live on the nodes of the grid. Bodies of one field
   * move together where they meet; those of several fields do not see each
   * other there. A node has one id in each field: with n fields node i has
   * the ids n i to n i + n - 1. With one field, ids are those of the nodes.
   */
  class VelocityFields
  {
  public:
    using Id = dealii::types::global_dof_index; ///< of a node, in one field

    /** One, that of all bodies. */
    VelocityFields() = default;

    /** @param of_body the field of each body; empty: all have the first */
    explicit VelocityFields(std::vector<unsigned int> of_body)
      : fields(std::move(of_body))
      , n(fields.empty() ? 1
                         : 1 + *std::max_element(fields.begin(), fields.end()))
    {}

    /** How many there are. */
    unsigned int
    size() const
    {
      return n;
    }
    /** The field that a body has. */
    unsigned int
    of_body(const unsigned int body) const
    {
      return fields.empty() ? 0 : fields[body];
    }
    /** The id of a node in a field. */
    Id
    id(const Id node, const unsigned int field) const
    {
      return n * node + field;
    }
    /** Without its field. */
    Id
    node(const Id id) const
    {
      return id / n;
    }
    /** Of a node's number. */
    unsigned int
    field(const Id id) const
    {
      return id % n;
    }
    /** The ids of some nodes in all fields. */
    dealii::IndexSet
    ids(const dealii::IndexSet &nodes) const
    {
      if (n == 1)
        return nodes;
      dealii::IndexSet result(n * nodes.size());
      for (auto part = nodes.begin_intervals(); part != nodes.end_intervals();
           ++part)
        result.add_range(n * *part->begin(), n * (part->last() + 1));
      result.compress();
      return result;
    }

  private:
    std::vector<unsigned int> fields;
    unsigned int              n = 1;
  };
} // namespace emmy

#endif
