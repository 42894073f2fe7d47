// fingerprint.cpp — hashes of scene, paints, sky and view.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/fingerprint.h"

#include <bit>
#include <cstdio>

#include "malus/core/sampler.h"

namespace malus {
namespace {

class Digest {
  public:
    void add(std::uint64_t value) { state_ = hash(state_, value); }
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
    std::string text() const {
        char digits[17];
        std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(state_));
        return digits;
    }

  private:
    std::uint64_t state_ = 0;
};

}  // namespace

std::string fingerprint(const Scene& scene) {
    Digest digest;
    for (const Mesh& mesh : scene.meshes) {
        digest.add_all(mesh.positions);
        digest.add_all(mesh.normals);
        digest.add(mesh.triangles.size());
        for (const auto& corners : mesh.triangles)
            for (std::uint32_t corner : corners) digest.add(std::uint64_t{corner});
    }
    for (const Instance& instance : scene.instances) {
        digest.add(static_cast<std::uint64_t>(instance.mesh));
        digest.add(static_cast<std::uint64_t>(instance.node));
        const Affine& m = instance.to_world;
        for (const Vec3& column : {m.x, m.y, m.z, m.t}) digest.add(column);
    }
    for (const Node& node : scene.nodes) digest.add(node.name);
    return digest.text();
}

std::string fingerprint(const std::vector<Material>& materials, const std::vector<int>& paints,
                        std::span<const double> wavelengths_nm) {
    Digest digest;
    for (int paint : paints) {
        const Material& material = materials[static_cast<std::size_t>(paint)];
        digest.add(material.name);
        digest.add(static_cast<std::uint64_t>(material.slopes));
        digest.add(static_cast<std::uint64_t>(material.attenuation));
        for (double nm : wavelengths_nm) {
            const PriestGermer<double> p = parameters_at(material, nm);
            for (double number : {nm, p.n, p.k, p.B, p.sigma, p.tau, p.inv_omega, p.rho_d, p.rho_v})
                digest.add(number);
        }
    }
    return digest.text();
}

std::string fingerprint(const Sky& sky, std::span<const double> wavelengths_nm) {
    Digest digest;
    digest.add_all(sky.zeniths);
    digest.add_all(sky.azimuths);
    const std::size_t nodes = sky.zeniths.size() * sky.azimuths.size();
    const bool disc = sky.sun && !sky.sun->irradiance.empty();
    if (disc) digest.add(sky.sun->zenith), digest.add(sky.sun->azimuth);
    for (std::size_t w : wavelength_indices(sky, wavelengths_nm)) {
        digest.add(sky.wavelengths_nm[w]);
        if (disc) digest.add(sky.sun->irradiance[w]);
        for (std::size_t i = 0; i < nodes; ++i) {
            const Stokes<double>& S = sky.nodes[w * nodes + i];
            digest.add(S.s0), digest.add(S.s1), digest.add(S.s2), digest.add(S.s3);
        }
    }
    return digest.text();
}

std::string fingerprint(const Camera& camera) {
    Digest digest;
    const bool perspective = camera.projection == Projection::kPerspective;
    digest.add(std::uint64_t{perspective});
    for (const Vec3& v : {camera.position, camera.right, camera.up, camera.forward}) digest.add(v);
    if (perspective)
        digest.add(camera.yfov);
    else
        digest.add(camera.xmag), digest.add(camera.ymag);
    return digest.text();
}

}  // namespace malus
