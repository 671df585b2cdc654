// SPDX-License-Identifier: Apache-2.0
// Makes volumes from arrays and from OpenVDB files.
#include "array_fields.h"
#include "bindings.h"

#include <scrim/volume/field_builder.h>
#include <scrim/guard/load_fields.h>
#include <scrim/volume/vdb_info.h>

#include <algorithm>
#include <cmath>
#include <map>

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <glm/gtc/matrix_inverse.hpp>

namespace scrim::python {
namespace {

Mat4 matrixFrom(nb::handle transform) {
    const nb::object rows = nb::module_::import_("numpy").attr("asarray")(transform);
    const char* const what = "a matrix of 4 x 4 numbers, row by row, whose last row is 0, 0, 0, 1";
    const std::vector<double> m = numbers(rows.attr("ravel")(), 16, what);
    if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
        throw Error(ErrorKind::usage, std::string("transform: expected ") + what);
    Mat4 out(1.0);
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column) out[column][row] = m[std::size_t(4 * row + column)];
    return out;
}

/// The map from voxels to the world: `transform`, or else from voxel size and the centre of the first voxel.
Mat4 placeOf(nb::handle voxelSize, nb::handle origin, nb::handle transform) {
    if (!transform.is_none()) {
        if (!voxelSize.is_none() || !origin.is_none())
            throw Error(ErrorKind::usage,
                        "transform: it says where voxels lie; expected neither voxel_size nor origin beside it");
        return matrixFrom(transform);
    }
    Mat4 place(1.0);
    if (!voxelSize.is_none()) {
        const bool one = nb::isinstance<nb::float_>(voxelSize) || nb::isinstance<nb::int_>(voxelSize);
        const std::vector<double> size = one ? std::vector<double>(3, nb::cast<double>(voxelSize))
                                             : numbers(voxelSize, 3, "a voxel size: one number or three");
        for (int axis = 0; axis < 3; ++axis) {
            const double edge = size[std::size_t(axis)];
            if (!(edge > 0) || !std::isfinite(edge))
                throw Error(ErrorKind::usage, "voxel_size: expected world units above 0");
            place[axis][axis] = edge;
        }
    }
    if (!origin.is_none()) {
        const std::vector<double> at = numbers(origin, 3, "an origin: three numbers");
        place[3] = {at[0], at[1], at[2], 1};
    }
    return place;
}

void makeField(Field* self, nb::handle numbersOfIt, nb::handle voxelSize, nb::handle nameOfIt, nb::handle origin,
               nb::handle transform) {
    const std::string name = textOf(nameOfIt, "the name of a grid");
    const NumberArray array(numbersOfIt, name);
    const Mat4 wsFromIs = placeOf(voxelSize, origin, transform);
    Field field{name, {}};
    doAndWait([&](Work& work) {
        field.grids = array.fields(name, wsFromIs);
        for (const SparseField& grid : field.grids) reportCleaning(grid, "array", work.messageSink());
    });
    new (self) Field(std::move(field));
}

/// The parts of a file that are to be read: a scalar grid, or the components of a colour.
struct Wanted {
    std::string name;
    std::vector<GridRequest> requests;
};

std::vector<Wanted> wantedOf(const VdbFileInfo& info, const std::optional<std::vector<std::string>>& names) {
    std::map<std::string, int> counts, seen;
    for (const GridInfo& grid : info.grids) ++counts[grid.name];
    std::vector<Wanted> all;
    std::vector<std::string> there;
    for (const GridInfo& grid : info.grids) {
        const int place = seen[grid.name]++;
        if (!grid.usable && !grid.colour) continue;
        const bool unique = counts[grid.name] == 1 && !grid.name.empty();
        const std::string name = unique ? grid.name : grid.name + "[" + std::to_string(place) + "]";
        there.push_back(name);
        Wanted wanted{name, {}};
        if (grid.colour)
            for (int c = 0; c < 3; ++c) wanted.requests.push_back({name, c});
        else
            wanted.requests.push_back({name});
        all.push_back(std::move(wanted));
    }
    if (!names) return all;
    std::vector<Wanted> chosen;
    for (const std::string& name : *names) {
        const auto found = std::find_if(all.begin(), all.end(), [&](const Wanted& w) { return w.name == name; });
        if (found == all.end())
            throw Error(ErrorKind::input, info.path + ": there is no grid '" + shortened(name, 80) +
                                              "' that could be rendered; there is " + choices(there));
        chosen.push_back(*found);
    }
    return chosen;
}

std::vector<Field> readVdb(nb::handle path, const std::optional<std::vector<std::string>>& grids, bool guarded) {
    const std::string file = pathText(path);
    LoadOptions load;
    load.volumes = guarded ? VolumeLoading::guarded : VolumeLoading::plain;
    std::vector<Field> fields;
    doAndWait([&](Work& work) {
        const std::vector<Wanted> wanted = wantedOf(loadInfo(file, load, work.checkpoint()), grids);
        std::vector<GridRequest> requests;
        for (const Wanted& w : wanted) requests.insert(requests.end(), w.requests.begin(), w.requests.end());
        if (requests.empty()) throw Error(ErrorKind::input, file + ": it holds no grid that could be rendered");
        std::vector<SparseField> read = loadFields(file, requests, load, work.messageSink(), work.checkpoint());
        auto next = read.begin();
        for (const Wanted& w : wanted) {
            Field& field = fields.emplace_back(Field{w.name, {}});
            for (std::size_t i = 0; i < w.requests.size(); ++i) field.grids.push_back(std::move(*next++));
        }
    });
    return fields;
}

nb::object boundsOf(const Field& field) {
    Bounds world;
    for (const SparseField& grid : field.grids) {
        if (grid.empty()) continue;
        for (const Vec3& corner : grid.isBounds().corners()) world.include(transformPoint(grid.wsFromIs, corner));
    }
    if (world.empty()) return nb::none();
    const auto point = [](const Vec3& p) { return std::make_tuple(p.x, p.y, p.z); };
    return nb::cast(std::make_tuple(point(world.lower), point(world.upper)));
}

}  // namespace

void bindFields(nb::module_& module) {
    nb::class_<Field>(module, "Field",
                      R"(A grid of a volume: numbers on a lattice of voxels, of which those above 0 are kept.

`array`: floats or whole numbers of shape (nx, ny, nz), or (nx, ny, nz, 3) for colours; element [x, y, z] is the voxel
at index x, y, z. Strides are respected; it is read once, here, and no other copy of it is made than the
blocks of the field. What is not finite or below 0 counts as 0.
`voxel_size`: world units, one number or three; 1 unless it is given.
`name`: what the scene calls the grid, 'density', 'temperature', 'Cd'.
`origin`: the centre of voxel [0, 0, 0] in world units; the world's origin unless it is given.
`transform`: instead of both, the 4x4 matrix from indices to the world, row by row, translation in the last column.)")
        .def("__init__", &makeField, nb::arg("array"), nb::arg("voxel_size") = nb::none(), nb::kw_only(),
             nb::arg("name") = "density", nb::arg("origin") = nb::none(), nb::arg("transform") = nb::none(),
             nb::sig("def __init__(self, array: numpy.typing.ArrayLike, voxel_size: float | "
                     "collections.abc.Sequence[float] | "
                     "None = None, *, name: str = 'density', origin: collections.abc.Sequence[float] | None = None, "
                     "transform: numpy.typing.ArrayLike | None = None) -> None"))
        .def_ro("name", &Field::name, "What the scene calls it.")
        .def_prop_ro(
            "active_voxels", [](const Field& f) { return f.grids.front().activeVoxels; },
            "Voxels above 0; of a colour, those of its red.")
        .def_prop_ro(
            "max",
            [](const Field& f) {
                float most = 0;
                for (const SparseField& grid : f.grids) most = std::max(most, grid.maxValue);
                return most;
            },
            "The largest value.")
        .def_prop_ro(
            "nbytes",
            [](const Field& f) {
                std::size_t bytes = 0;
                for (const SparseField& grid : f.grids) bytes += grid.bytes();
                return bytes;
            },
            "Memory that it takes, in bytes.")
        .def_prop_ro(
            "bounds", &boundsOf,
            nb::sig("def bounds(self) -> tuple[tuple[float, float, float], tuple[float, float, float]] | None"),
            "Lower and upper corner of the box around the centres of its voxels, to blocks of 8, in world "
            "units; None where it is empty.")
        .def("__repr__", [](const Field& f) {
            return "<scrim.Field '" + f.name + "', " + std::to_string(f.grids.front().activeVoxels) + " voxels>";
        });
    module.def(
        "read_vdb", &readVdb, nb::arg("path"), nb::arg("grids") = nb::none(), nb::kw_only(), nb::arg("guarded") = true,
        nb::sig("def read_vdb(path: str | os.PathLike[str], grids: collections.abc.Sequence[str] | None = None, *, "
                "guarded: bool = True) -> list[Field]"),
        R"(Grids of an OpenVDB file: those named, or all that can be rendered.

Of equal names 'density[1]' is the second. Level sets become fog. `guarded`: in a child process, which a damaged file
cannot take over.)");
}

}  // namespace scrim::python
