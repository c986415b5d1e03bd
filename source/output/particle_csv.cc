#include <emmy/base/exceptions.h>
#include <emmy/base/whole_file.h>
#include <emmy/effects/mean_dilatation.h>
#include <emmy/math/mandel.h>
#include <emmy/output/particle_csv.h>
#include <emmy/output/particle_fields.h>

#include <cmath>
#include <cstdio>

namespace emmy
{
  namespace
  {
    std::string
    all_digits(const double number)
    {
      char text[32];
      std::snprintf(text, sizeof text, ",%.17g", number);
      return text;
    }

    /** Names of what the table has of each particle behind its volume. */
    std::vector<std::string>
    field_names(const FieldLayout &layout)
    {
      std::vector<std::string> names{"mass",
                                     "velocity",
                                     "elastic_strain",
                                     "logarithmic_strain",
                                     "cauchy_stress"};
      // what materials remember, and the treatment of locking
      for (const Field &field : layout.fields())
        if (field.kind == Field::Kind::scalar &&
            (field.asked_by == mean_dilatation_effect ||
             field.asked_by.rfind("material ", 0) == 0))
          names.push_back(field.name);
      return names;
    }
  } // namespace

  template <int dim>
  void
  write_particle_csv(const std::string                             &filename,
                     const FieldLayout                             &layout,
                     const dealii::Particles::ParticleHandler<dim> &particles,
                     const MPI_Comm communicator)
  {
    const auto fields =
      ParticleFields<dim>(layout).find(field_names(layout), "Output", "");
    const unsigned int body   = layout["body"],
                       volume = layout["reference_volume"],
                       b      = layout["left_cauchy_green_less_unit"];
    std::string text;
    for (const auto &particle : particles)
      {
        const auto        properties = particle.get_properties();
        MandelVector<dim> deformation;
        for (unsigned int c = 0; c < n_mandel<dim>; ++c)
          deformation[c] = properties[b + c];
        text +=
          std::to_string(particle.get_id()) + all_digits(properties[body]);
        for (unsigned int d = 0; d < dim; ++d)
          text += all_digits(particle.get_location()[d]);
        text += all_digits(
          properties[volume] *
          std::sqrt(1. + mandel::determinant_less_one<dim>(deformation)));
        for (const auto &field : fields)
          {
            std::vector<double> values;
            field.append(particle, values);
            for (const auto &component : field.components)
              text += all_digits(values[component.second]);
          }
        text += '\n';
      }
    const auto  parts = dealii::Utilities::MPI::gather(communicator, text);
    std::string problem;
    if (!parts.empty()) // on the first rank
      {
        std::string whole =
          dim == 2 ? "id,body,x,y,volume" : "id,body,x,y,z,volume";
        for (const auto &field : fields)
          for (const auto &component : field.components)
            whole += "," + field.description.name +
                     (component.first.empty() ? "" : "_") + component.first;
        whole += '\n';
        for (const std::string &part : parts)
          whole += part;
        problem = write_whole_file(filename, whole);
      }
    throw_together(communicator, "Output", problem, file_remedy);
  }

  template void
  write_particle_csv<2>(const std::string &,
                        const FieldLayout &,
                        const dealii::Particles::ParticleHandler<2> &,
                        const MPI_Comm);
  template void
  write_particle_csv<3>(const std::string &,
                        const FieldLayout &,
                        const dealii::Particles::ParticleHandler<3> &,
                        const MPI_Comm);
} // namespace emmy
