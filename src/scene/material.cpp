// material.cpp — paints between their rows, and onto the scene.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/material.h"

#include <algorithm>
#include <optional>

#include "malus/core/error.h"
#include "malus/optics/wavelengths.h"

namespace malus {
namespace {

PriestGermer<double> between(const PriestGermer<double>& a, const PriestGermer<double>& b,
                             double t) {
    const auto mix = [t](double x, double y) { return (1 - t) * x + t * y; };
    const double omega = a.inv_omega > 0 ? mix(1 / a.inv_omega, 1 / b.inv_omega) : 0;
    return {mix(a.n, b.n),         mix(a.k, b.k),        mix(a.B, b.B),
            mix(a.sigma, b.sigma), mix(a.tau, b.tau),    omega > 0 ? 1 / omega : 0,
            mix(a.rho_d, b.rho_d), mix(a.rho_v, b.rho_v)};
}

std::vector<std::string> names_of(const std::vector<Material>& materials) {
    std::vector<std::string> names;
    for (const Material& m : materials) names.push_back(m.name);
    return names;
}

// One line for a surface without paint: what it is called and what can be done.
std::string surface_place(const Scene& scene, const Instance& instance) {
    const Mesh& mesh = scene.meshes[static_cast<std::size_t>(instance.mesh)];
    const Node& node = scene.nodes[static_cast<std::size_t>(instance.node)];
    std::string text = "node '" + one_line(node.name) + "'";
    text += mesh.surface < 0
                ? " (no glTF material)"
                : " (glTF material '" +
                      one_line(scene.surfaces[static_cast<std::size_t>(mesh.surface)]) + "')";
    return text;
}

class PaintBook {
  public:
    PaintBook(const Scene& scene, const std::vector<PaintRule>& rules,
              const std::vector<Material>& materials)
        : scene_(scene), names_(names_of(materials)), rules_(rules) {
        for (const PaintRule& rule : rules) paints_.push_back(paint_named(rule));
    }

    std::optional<int> of(const Instance& instance) const {
        const Mesh& mesh = scene_.meshes[static_cast<std::size_t>(instance.mesh)];
        for (int n = instance.node; n >= 0; n = scene_.nodes[static_cast<std::size_t>(n)].parent)
            if (const auto paint = rule_for(scene_.nodes[static_cast<std::size_t>(n)].name))
                return paint;
        if (const auto paint = rule_for(mesh.name)) return paint;
        const bool named = mesh.surface >= 0;
        const std::string own =
            named ? scene_.surfaces[static_cast<std::size_t>(mesh.surface)] : std::string();
        if (const auto paint = named ? rule_for(own) : std::nullopt) return paint;
        if (const auto paint = rule_for("*")) return paint;
        const auto found = std::find(names_.begin(), names_.end(), own);
        if (named && found != names_.end()) return static_cast<int>(found - names_.begin());
        return std::nullopt;
    }

    // A rule that names nothing in the scene is a slip of the pen.
    void check_names() const {
        std::vector<std::string> known;
        const auto add = [&](const std::string& name) {
            if (!name.empty() && std::find(known.begin(), known.end(), name) == known.end())
                known.push_back(name);
        };
        for (const Node& node : scene_.nodes) add(node.name);
        for (const Mesh& mesh : scene_.meshes) add(mesh.name);
        for (const std::string& surface : scene_.surfaces) add(surface);
        for (const PaintRule& rule : rules_)
            if (rule.name != "*" && std::find(known.begin(), known.end(), rule.name) == known.end())
                throw Error("--assign " + one_line(rule.name) +
                            ": the scene has no node, mesh or material of this name" +
                            suggest(rule.name, known));
    }

    std::string known_paints() const { return suggest("", names_); }

  private:
    int paint_named(const PaintRule& rule) const {
        const auto found = std::find(names_.begin(), names_.end(), rule.material);
        if (found == names_.end())
            throw Error("--assign " + one_line(rule.name) + "=" + one_line(rule.material) +
                        ": unknown material" + suggest(rule.material, names_));
        return static_cast<int>(found - names_.begin());
    }

    std::optional<int> rule_for(const std::string& name) const {
        if (name.empty()) return std::nullopt;
        // The last of several rules for one name holds, as options on a command line do.
        for (std::size_t i = rules_.size(); i-- > 0;)
            if (rules_[i].name == name) return paints_[i];
        return std::nullopt;
    }

    const Scene& scene_;
    std::vector<std::string> names_;
    const std::vector<PaintRule>& rules_;
    std::vector<int> paints_;
};

}  // namespace

bool Material::covers(double wavelength_nm) const {
    return wavelength_nm > rows.front().wavelength_nm - kSameWavelength_nm &&
           wavelength_nm < rows.back().wavelength_nm + kSameWavelength_nm;
}

PriestGermer<double> parameters_at(const Material& material, double wavelength_nm) {
    const auto& rows = material.rows;
    for (const MaterialRow& row : rows)
        if (std::abs(row.wavelength_nm - wavelength_nm) < kSameWavelength_nm) return row.p;
    if (!material.covers(wavelength_nm))
        throw Error(material.place + ": no data at " + to_text(wavelength_nm) + " nm (rows cover " +
                    to_text(rows.front().wavelength_nm) + " to " +
                    to_text(rows.back().wavelength_nm) + " nm); choose other --wavelengths");
    const auto above = std::find_if(rows.begin(), rows.end(), [&](const MaterialRow& row) {
        return row.wavelength_nm > wavelength_nm;
    });
    const MaterialRow &a = *(above - 1), &b = *above;
    if ((a.p.inv_omega > 0) != (b.p.inv_omega > 0))
        throw Error(
            material.place + ": no shadowing at " + to_text(wavelength_nm) +
            " nm (only one of the rows around it has it); give both rows shadowing or none");
    return between(a.p, b.p,
                   (wavelength_nm - a.wavelength_nm) / (b.wavelength_nm - a.wavelength_nm));
}

std::vector<int> assign_paints(const Scene& scene, const std::vector<PaintRule>& rules,
                               const std::vector<Material>& materials) {
    const PaintBook book(scene, rules, materials);
    book.check_names();
    std::vector<int> paints;
    for (const Instance& instance : scene.instances) {
        const auto paint = book.of(instance);
        if (!paint)
            throw Error(surface_place(scene, instance) + ": no paint of that name" +
                        book.known_paints() + "; assign one with --assign NAME=MATERIAL");
        paints.push_back(*paint);
    }
    return paints;
}

}  // namespace malus
