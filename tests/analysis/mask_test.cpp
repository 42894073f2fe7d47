// mask_test.cpp — pixels by name and by distance.
// SPDX-License-Identifier: Apache-2.0
#include "malus/analysis/mask.h"

#include "malus/core/error.h"
#include "support/catch.h"

using namespace malus;
using Catch::Contains;

namespace {

// Eight pixels in a row: sky, ground, hull, wheel, wheel, hull, ground, sky.
Image row() {
    Image image;
    image.width = 8, image.height = 1;
    image.channel("A") = {0, 1, 0.5f, 1, 1, 1, 1, 0};
    image.channel("node.id") = {0, 1, 3, 2, 2, 3, 1, 0};
    image.channel("material.id") = {0, 1, 2, 1, 1, 2, 1, 0};
    image.attributes["nodeNames"] =
        std::vector<std::string>{"(sky)", "ground", "wheel", "hull", "tank"};
    // As glTF allows, a parent after its children.
    image.attributes["nodeParents"] = std::vector<std::string>{"0", "0", "3", "4", "0"};
    image.attributes["materialNames"] = std::vector<std::string>{"(sky)", "black", "green"};
    return image;
}

}  // namespace

TEST_CASE("Masks: a node is meant with all below it, a material wherever it is") {
    const Image image = row();
    CHECK(surface_mask(image) == Mask{0, 1, 1, 1, 1, 1, 1, 0});
    CHECK(node_mask(image, "ground") == Mask{0, 1, 0, 0, 0, 0, 1, 0});
    CHECK(node_mask(image, "wheel") == Mask{0, 0, 0, 1, 1, 0, 0, 0});
    CHECK(node_mask(image, "hull") == Mask{0, 0, 1, 1, 1, 1, 0, 0});
    CHECK(node_mask(image, "tank") == Mask{0, 0, 1, 1, 1, 1, 0, 0});
    CHECK(material_mask(image, "green") == Mask{0, 0, 1, 0, 0, 1, 0, 0});
    CHECK(without(surface_mask(image), node_mask(image, "tank")) == Mask{0, 1, 0, 0, 0, 0, 1, 0});
    CHECK(both(material_mask(image, "black"), node_mask(image, "tank")) ==
          Mask{0, 0, 0, 1, 1, 0, 0, 0});
    CHECK(count(node_mask(image, "tank")) == 4);
}

TEST_CASE("Masks: names that the image lacks are refused with the nearest") {
    CHECK_THROWS_WITH(node_mask(row(), "whel"),
                      Contains("no node 'whel'") && Contains("did you mean 'wheel'?"));
    CHECK_THROWS_WITH(material_mask(row(), "blck"), Contains("did you mean 'black'?"));
    Image nameless = row();
    nameless.attributes.erase("nodeNames");
    CHECK_THROWS_WITH(node_mask(nameless, "wheel"), Contains("no list 'nodeNames'"));
    Image circular = row();
    circular.attributes["nodeParents"] = std::vector<std::string>{"0", "2", "1", "9", "x"};
    CHECK(node_mask(circular, "wheel") == Mask{0, 1, 0, 1, 1, 0, 1, 0});
}

TEST_CASE("Masks: a ring holds the pixels between two distances") {
    // One pixel in a field: squared distances of a lattice, by hand.
    Mask inner(49, 0);
    inner[24] = 1;
    const Mask ring = ring_around(inner, 7, 7, 1, std::sqrt(5.0) + 1e-9);
    CHECK(count(ring) == 4 + 4 + 8);  // distances √2, 2, √5
    CHECK(!ring[24]);
    CHECK(!ring[23]);       // at 1
    CHECK(ring[24 - 8]);    // at √2
    CHECK(!ring[24 - 16]);  // at √8
    CHECK(count(ring_around(inner, 7, 7, 0, 100)) == 48);
    CHECK(count(ring_around(Mask(49, 0), 7, 7, 0, 100)) == 0);
}
