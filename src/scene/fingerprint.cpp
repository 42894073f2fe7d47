// fingerprint.cpp — hashes of scene, paints, sky and view.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/fingerprint.h"

#include <bit>
#include <cmath>

#include "malus/core/digest.h"

namespace malus {
namespace {

// What the marks are made of, as numbers of the same on every machine.
class Marks {
  public:
    void add(std::uint64_t value) { digest_.add(value); }
    void add(double number) {
        // −0 is 0.
        add(std::uint64_t{std::bit_cast<std::uint32_t>(static_cast<float>(number) + 0.0f)});
    }
    void add(const Vec3f& v) {
        for (float x : {v.x, v.y, v.z}) add(static_cast<double>(x));
    }
    // To a millionth of its length: a 0 that was computed may be 1e-17 elsewhere.
    void add(const Vec3& v) {
        const double size = length(v);
        add(size);
        for (double x : {v.x, v.y, v.z})
            add(static_cast<std::uint64_t>(size > 0 ? std::llround(x / size * 0x1p20) : 0));
    }
    void add(const std::string& text) {
        add(text.size());
        for (char c : text) add(std::uint64_t{static_cast<unsigned char>(c)});
    }
    template <class T>
    void add_all(const std::vector<T>& list) {
        add(list.size());
        for (const T& item : list) add(item);
    }
    std::string text() const { return digest_.text(); }

  private:
    Digest digest_;
};

}  // namespace

std::string fingerprint(const Scene& scene) {
    Marks marks;
    for (const Mesh& mesh : scene.meshes) {
        marks.add_all(mesh.positions);
        marks.add_all(mesh.normals);
        marks.add(mesh.triangles.size());
        for (const auto& corners : mesh.triangles)
            for (std::uint32_t corner : corners) marks.add(std::uint64_t{corner});
    }
    for (const Instance& instance : scene.instances) {
        marks.add(static_cast<std::uint64_t>(instance.mesh));
        marks.add(static_cast<std::uint64_t>(instance.node));
        const Affine& m = instance.to_world;
        for (const Vec3& column : {m.x, m.y, m.z, m.t}) marks.add(column);
    }
    for (const Node& node : scene.nodes) marks.add(node.name);
    return marks.text();
}

std::string fingerprint(const std::vector<Material>& materials, const std::vector<int>& paints,
                        std::span<const double> wavelengths_nm) {
    Marks marks;
    for (int paint : paints) {
        const Material& material = materials[static_cast<std::size_t>(paint)];
        marks.add(material.name);
        marks.add(static_cast<std::uint64_t>(material.slopes));
        marks.add(static_cast<std::uint64_t>(material.attenuation));
        for (double nm : wavelengths_nm) {
            const PriestGermer<double> p = parameters_at(material, nm);
            for (double number : {nm, p.n, p.k, p.B, p.sigma, p.tau, p.inv_omega, p.rho_d, p.rho_v})
                marks.add(number);
        }
    }
    return marks.text();
}

std::string fingerprint(const Sky& sky, std::span<const double> wavelengths_nm) {
    Marks marks;
    marks.add_all(sky.zeniths);
    marks.add_all(sky.azimuths);
    const std::size_t nodes = sky.zeniths.size() * sky.azimuths.size();
    const bool disc = sky.sun && !sky.sun->irradiance.empty();
    if (disc) marks.add(sky.sun->zenith), marks.add(sky.sun->azimuth);
    for (std::size_t w : wavelength_indices(sky, wavelengths_nm)) {
        marks.add(sky.wavelengths_nm[w]);
        if (disc) marks.add(sky.sun->irradiance[w]);
        for (std::size_t i = 0; i < nodes; ++i) {
            const Stokes<double>& S = sky.nodes[w * nodes + i];
            marks.add(S.s0), marks.add(S.s1), marks.add(S.s2), marks.add(S.s3);
        }
    }
    return marks.text();
}

std::string fingerprint(const Camera& camera) {
    Marks marks;
    const bool perspective = camera.projection == Projection::kPerspective;
    marks.add(std::uint64_t{perspective});
    for (const Vec3& v : {camera.position, camera.right, camera.up, camera.forward}) marks.add(v);
    if (perspective)
        marks.add(camera.yfov);
    else
        marks.add(camera.xmag), marks.add(camera.ymag);
    return marks.text();
}

}  // namespace malus
