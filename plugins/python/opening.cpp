// SPDX-License-Identifier: Apache-2.0
// Makes shots from files, text and dicts.
#include "bindings.h"

#include <scrim/scene/scene_help.h>

#include <tuple>

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

namespace scrim::python {
namespace {

OpenOptions openOptionsFrom(const std::string& ocio, const std::optional<std::tuple<int, int>>& resolution,
                            nb::handle up, int turntable, bool guarded, int checkedFrame) {
    OpenOptions options;
    options.ocio = ocio;
    if (resolution) {
        const auto& [width, height] = *resolution;
        if (width < 1 || height < 1) throw Error(ErrorKind::usage, "resolution: expected width and height in pixels");
        options.resolution = Int2(width, height);
    }
    if (!up.is_none()) {
        const std::vector<double> axis = numbers(up, 3, "an axis such as (0, 0, 1)");
        options.wsUp = Vec3(axis[0], axis[1], axis[2]);
    }
    if (turntable < 0) throw Error(ErrorKind::usage, "turntable: expected 0 (none), or how many frames");
    options.turntable = turntable;
    options.load.volumes = guarded ? VolumeLoading::guarded : VolumeLoading::plain;
    options.checkedFrame = checkedFrame;
    options.gridsFromCode = true;
    return options;
}

template <typename Open>
ShotObject opened(const Open& open) {
    ShotObject object;
    doAndWait([&](Work&) { object.state = std::make_shared<ShotState>(open()); });
    return object;
}

}  // namespace

std::vector<std::string> assignmentsOf(nb::handle overrides) {
    std::vector<std::string> texts;
    for (const nb::handle text : nb::module_::import_("scrim._toml").attr("assignments")(overrides))
        texts.push_back(textOf(text, "an override"));
    return texts;
}

void bindOpening(nb::module_& module) {
    module.def(
        "scene_schema", [] { return fromJson(sceneSchema()); }, nb::sig("def scene_schema() -> dict[str, typing.Any]"),
        "The table of all keys as a JSON schema: `scrim help --schema`.");
    module.def(
        "open",
        [](nb::handle path, nb::handle overrides, nb::handle ocio,
           const std::optional<std::tuple<int, int>>& resolution, nb::handle up, int turntable, bool guarded,
           int checkedFrame) {
            const OpenOptions options =
                openOptionsFrom(pathText(ocio), resolution, up, turntable, guarded, checkedFrame);
            const std::string file = pathText(path);
            const std::vector<std::string> given = assignmentsOf(overrides);
            return opened([&] { return Shot::open(file, given, options); });
        },
        nb::arg("path"), nb::arg("overrides") = nb::none(), nb::kw_only(), nb::arg("ocio") = "",
        nb::arg("resolution") = nb::none(), nb::arg("up") = nb::none(), nb::arg("turntable") = 0,
        nb::arg("guarded") = true, nb::arg("checked_frame") = 1,
        nb::sig(
            "def open(path: str | os.PathLike[str], overrides: collections.abc.Mapping[str, object] | "
            "collections.abc.Sequence[str] | None = None, *, ocio: str | os.PathLike[str] = '', resolution: tuple[int, "
            "int] | None = None, up: collections.abc.Sequence[float] | None = None, turntable: int = 0, guarded: bool "
            "= "
            "True, checked_frame: int = 1) -> Shot"),
        R"(Opens a scene (.toml) or an asset (.vdb, or a scan: .nrrd, .nhdr, .nii, .nii.gz, .hdr, .mha, .mhd, .npy, .mrc, .vti, .tif, .dcm, a folder of DICOM or TIFF slices), which is framed and lit.

`overrides`: {'camera.fov': 20, 'light.key.color': [1, 0.8, 0.6]}, or the list ['camera.fov=20'] of `scrim --set`.
`ocio`: an OpenColorIO config; '': $OCIO, or else Scrim's own.  `resolution`: width, height in place of the scene's.
`up`: of an asset's world, an axis such as (0, 0, 1).  `turntable`: frames in which the camera goes once around.
`guarded`: files are read in child processes, which a damaged file cannot take over.
`checked_frame`: the scene is checked at this frame now. A [[volume]] without a file waits for `Shot.set_volume`.)");
    module.def(
        "loads",
        [](nb::handle scene, nb::handle overrides, nb::handle folder, nb::handle nameOfIt, nb::handle ocio,
           const std::optional<std::tuple<int, int>>& resolution, int turntable, bool guarded, int checkedFrame,
           const ShotObject* sharing) {
            OpenOptions options =
                openOptionsFrom(pathText(ocio), resolution, nb::none(), turntable, guarded, checkedFrame);
            if (sharing != nullptr) options.shareWith = &sharing->shot();
            const std::string text = textOf(nb::module_::import_("scrim._toml").attr("document")(scene), "a scene");
            const std::string name = pathText(nameOfIt);  // usually that of a file
            const std::string base = pathText(folder);
            const std::vector<std::string> given = assignmentsOf(overrides);
            return opened([&] { return Shot::parse(text, name, base, given, options); });
        },
        nb::arg("scene"), nb::arg("overrides") = nb::none(), nb::kw_only(), nb::arg("folder") = "",
        nb::arg("name") = "scene", nb::arg("ocio") = "", nb::arg("resolution") = nb::none(), nb::arg("turntable") = 0,
        nb::arg("guarded") = true, nb::arg("checked_frame") = 1, nb::arg("sharing") = nb::none(),
        nb::sig("def loads(scene: str | collections.abc.Mapping[str, object], overrides: collections.abc.Mapping[str, "
                "object] "
                "| collections.abc.Sequence[str] | None = None, *, folder: str | os.PathLike[str] = '', name: str = "
                "'scene', "
                "ocio: str | os.PathLike[str] = '', resolution: tuple[int, int] | None = None, turntable: int = 0, "
                "guarded: "
                "bool = True, checked_frame: int = 1, sharing: Shot | None = None) -> Shot"),
        R"(A shot of a scene in memory: TOML text, or the same as a dict, {'camera': {...}, 'volume': [{...}], ...}.

`folder`: what its paths are relative to; '': the current folder.  `name`: how messages call it.
`sharing`: another shot, whose volumes and pictures this one need not load again; only one of the two may be at work.
Otherwise as `open`.)");
}

}  // namespace scrim::python
