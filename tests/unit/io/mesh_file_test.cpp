// Meshes of STL and OBJ files, and files that are none.
#include "io/mesh_file.hpp"

#include "skein/core/error.hpp"
#include "support/meshes.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <limits>

#include <fmt/format.h>

namespace skein {
namespace {

class MeshFile : public testing::Test {
protected:
    std::string write(const std::string& name, const std::string& text) const {
        const std::string path = testing::TempDir() + "mesh_file_test_" + name;
        std::ofstream(path, std::ios::binary) << text;
        return path;
    }
    void refuses(const std::string& name, const std::string& text, const std::string& fault) const {
        const std::string path = write(name, text);
        try {
            read_mesh(path, 1);
            ADD_FAILURE() << name << " was read";
        } catch (const InputError& error) {
            EXPECT_EQ(std::string(error.what()).substr(0, path.size()), path);
            EXPECT_NE(std::string(error.what()).find(fault), std::string::npos) << error.what();
        }
    }
};

const test::Mesh box = test::box_mesh({1, 2, 0.5});

std::string text_stl(const test::Mesh& mesh) {
    std::string text = "solid box\n";
    for (const auto& t : mesh.triangles) {
        text += "  facet normal 0 0 0\n    outer loop\n";
        for (const std::uint32_t p : t)
            text += fmt::format("      vertex {} {} {:e}\n", mesh.points[p].x, mesh.points[p].y, mesh.points[p].z);
        text += "    endloop\n  endfacet\n";
    }
    return text + "endsolid box\n";
}

std::string binary_stl(const test::Mesh& mesh) {
    std::string bytes = "solid by a program" + std::string(62, ' ');
    const auto append = [&](const auto& number) {
        bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
    };
    append(static_cast<std::uint32_t>(mesh.triangles.size()));
    for (const auto& t : mesh.triangles) {
        for (int i = 0; i < 3; ++i) append(0.0f);
        for (const std::uint32_t p : t)
            for (const double x : {mesh.points[p].x, mesh.points[p].y, mesh.points[p].z}) append(static_cast<float>(x));
        append(std::uint16_t{0});
    }
    return bytes;
}

/// Four quadrilaterals and four triangles, by numbers from the first and the last point.
const std::string obj =
    "# a box\no box\nv -1 -2 -0.5\nv 1 -2 -0.5\nv -1 2 -0.5\nv 1 2 -0.5\n"
    "v -1 -2 0.5\nv 1 -2 0.5\nv -1 2 0.5\nv 1 2 0.5\nvn 0 0 1\nusemtl grey\n"
    "f 1 3 4 2\nf -4//1 -3//1 -1//1 -2//1\nf 1/1 2/2 6/1 5/1\nf 3 7 8 4\nf 1 5 7\nf 1 7 3\nf 2 4 8\nf 2 8 6\n";

TEST_F(MeshFile, ReadsTextAndBinaryStlAndObj) {
    for (const auto& [name, text] :
         {std::pair{"a.stl", text_stl(box)}, std::pair{"b.STL", binary_stl(box)}, std::pair{"c.obj", obj}}) {
        const auto mesh = read_mesh(write(name, text), 0.1);
        EXPECT_EQ(mesh->triangles().size(), 12u) << name;
        EXPECT_NEAR(mesh->solid().volume, 8e-3, 1e-15) << name;
        EXPECT_NEAR(mesh->distance({0.01, 0, 0.02}), -0.03, 1e-15) << name;
    }
}

TEST_F(MeshFile, RefusesFilesWithTheirLineOrTriangle) {
    std::string text = text_stl(box);
    refuses("nan.stl", std::string(text).replace(text.find("vertex 1"), 8, "vertex nan"), "coordinates must be finite");
    refuses("word.stl", std::string(text).replace(text.find("vertex -1"), 9, "vertex wide"),
            ":4: 'wide' is not a number");
    refuses("two.stl", std::string(text).replace(text.find("      vertex"), 12, "#"),
            ":8: a facet has three corners, this one 2");
    refuses("short.stl", text.substr(0, text.rfind("    endloop")), "the file ends within the facet of line");
    refuses("empty.stl", "solid nothing\nendsolid nothing\n", ": no triangles in it");
    refuses("nothing.stl", "", "no STL file");
    refuses("line.stl", "solid box\nface 1 2 3\n", ":2: 'face' is no line of an STL file");
    const std::string bytes = binary_stl(box);
    refuses("cut.stl", "x" + bytes.substr(1, bytes.size() - 8), "of 12 triangles has 684 bytes, this one 677");
    std::string bad = bytes;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(bad.data() + 84 + 3 * 50 + 12, &nan, sizeof nan);
    refuses("nan_b.stl", bad, ": triangle 4: a corner is at (nan,");
    test::Mesh open = box;
    open.triangles.erase(open.triangles.begin());
    refuses("open.stl", binary_stl(open), "belongs to this triangle alone");
    refuses("open_t.stl", text_stl(open), ".stl:");
    refuses("point.obj", obj + "f 1 2 9\n", ":21: point 9 of 8 points before this line");
    refuses("zero.obj", obj + "f 0 2 3\n", ":21: '0' names no point");
    refuses("two.obj", obj + "f 1 2\n", ":21: a face has three corners at least, this one 2");
    refuses("coordinates.obj", "v 1 2\n", ":1: expected three coordinates, found 2");
    refuses("mesh.ply", "ply\n", "end in .stl or .obj");
}

} // namespace
} // namespace skein
