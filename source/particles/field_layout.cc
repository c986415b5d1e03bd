#include <deal.II/base/exceptions.h>

#include <emmy/particles/field_layout.h>

namespace emmy
{
  FieldLayout::FieldLayout(const unsigned int dim)
    : dim(dim)
  {}

  void
  FieldLayout::set_effect(const std::string &name)
  {
    effect = name;
  }

  unsigned int
  FieldLayout::add(const Field &field)
  {
    if (has(field.name))
      return (*this)[field.name];
    Field entry    = field;
    entry.offset   = n_components();
    entry.asked_by = effect;
    switch (field.kind)
      {
        case Field::Kind::scalar:
          entry.n_components = 1;
          break;
        case Field::Kind::vector:
          entry.n_components = dim;
          break;
        case Field::Kind::symmetric_tensor:
          entry.n_components = dim == 2 ? 4 : 6;
          break;
        case Field::Kind::tensor:
          entry.n_components = dim * dim;
          break;
      }
    entry.initial.resize(entry.n_components, 0.);
    list.push_back(entry);
    return entry.offset;
  }

  unsigned int
  FieldLayout::operator[](const std::string &name) const
  {
    for (const Field &field : list)
      if (field.name == name)
        return field.offset;
    for (const Field &field : list)
      AssertThrow(field.written_as != name,
                  dealii::ExcMessage("Particles carry the field <" + name +
                                     "> less a constant, as <" + field.name +
                                     ">. Read that, and add the constant."));
    AssertThrow(false,
                dealii::ExcMessage("The particles have no field <" + name +
                                   ">. The effect that uses it must ask for "
                                   "it when the scene is built."));
    return 0;
  }

  bool
  FieldLayout::has(const std::string &name) const
  {
    for (const Field &field : list)
      if (field.name == name)
        return true;
    return false;
  }

  const std::vector<Field> &
  FieldLayout::fields() const
  {
    return list;
  }

  std::vector<double>
  FieldLayout::initial_values() const
  {
    std::vector<double> values;
    for (const Field &field : list)
      values.insert(values.end(), field.initial.begin(), field.initial.end());
    return values;
  }

  unsigned int
  FieldLayout::n_components() const
  {
    return list.empty() ? 0 : list.back().offset + list.back().n_components;
  }

  FieldLayout
  basic_fields(const unsigned int dim)
  {
    FieldLayout layout(dim);
    layout.add({"velocity", Field::Kind::vector, "m/s", "velocity"});
    layout.add({"mass", Field::Kind::scalar, "kg", "mass, constant in time"});
    layout.add({"reference_volume",
                Field::Kind::scalar,
                "m^3",
                "undeformed volume (per metre of thickness in plane strain)"});
    layout.add({"body",
                Field::Kind::scalar,
                "1",
                "index of the body in the list Bodies/Names, from 0"});
    return layout;
  }
} // namespace emmy
