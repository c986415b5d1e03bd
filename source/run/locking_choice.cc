#include <emmy/base/text.h>
#include <emmy/run/scene_parameters.h>

#include <algorithm>

namespace emmy
{
  template <int dim>
  void
  SceneParameters<dim>::choose_locking_treatment()
  {
    std::string &treatment = method.locking_treatment;
    const bool   has_place =
      !time.is_explicit() &&
      (method.shape_functions != "GIMP" || method.domain_update != "corners") &&
      (time.is_static() || method.stress_rule == "conserving");
    const bool   is_automatic = treatment == "automatic";
    unsigned int n_used       = 0;
    for (unsigned int m = 0; m < materials.size(); ++m)
      {
        const auto is_of = [&](const auto &body) {
          return body->material == material_names.names[m];
        };
        if (std::none_of(bodies.begin(), bodies.end(), is_of))
          continue;
        ++n_used;
        const bool flows =
          !material_library<dim>()
             .find(materials[m]->model_name(), materials[m]->path(), "Model")
             .card.fields.empty();
        const bool may_lock =
          has_place && (flows || materials[m]->is_nearly_incompressible());
        if (treatment == "cell" || (is_automatic && may_lock))
          locking_materials.push_back(material_names.names[m]);
      }
    const bool is_same_for_all =
      locking_materials.empty() || locking_materials.size() == n_used;
    if (!is_automatic || n_used == 0 || // the reference is no scene
        !is_same_for_all)
      return;
    treatment = locking_materials.empty() ? "none" : "cell";
    // the parameters that a run writes say what it does
    auto &prm = dealii::ParameterAcceptor::prm;
    prm.enter_subsection("Method");
    prm.set("Locking treatment", treatment);
    prm.leave_subsection();
  }

  template <int dim>
  std::vector<bool>
  SceneParameters<dim>::are_treated(
    const std::vector<Body<dim>> &of_scene) const
  {
    std::vector<bool> result;
    for (const Body<dim> &body : of_scene)
      result.push_back(std::count(locking_materials.begin(),
                                  locking_materials.end(),
                                  material_names.names[body.material]) > 0);
    return result;
  }

  template <int dim>
  std::string
  SceneParameters<dim>::locking_summary() const
  {
    if (locking_materials.empty())
      return {};
    return ", mean dilatation of cells" +
           (method.locking_treatment == "cell"
              ? std::string()
              : " of " + join(locking_materials));
  }

  template void
  SceneParameters<2>::choose_locking_treatment();
  template void
  SceneParameters<3>::choose_locking_treatment();
  template std::vector<bool>
  SceneParameters<2>::are_treated(const std::vector<Body<2>> &) const;
  template std::vector<bool>
  SceneParameters<3>::are_treated(const std::vector<Body<3>> &) const;
  template std::string
  SceneParameters<2>::locking_summary() const;
  template std::string
  SceneParameters<3>::locking_summary() const;
} // namespace emmy
