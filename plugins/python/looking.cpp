// SPDX-License-Identifier: Apache-2.0
// What viewers ask a shot beside its pictures: the scene at a frame in plain numbers, and pictures as a display shows
// them. Python computes neither by itself, so a viewer shows what the program renders and previews.
#include "bindings.h"

#include <scrim/image/colour.h>
#include <scrim/scene/keyed.h>

#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

namespace scrim::python {
namespace {

using Floats = nb::ndarray<const float, nb::ndim<3>, nb::c_contig, nb::device::cpu>;

nb::object listOf(const Vec3& v) {
    nb::list out;
    for (int i = 0; i < 3; ++i) out.append(v[i]);
    return out;
}

nb::list rowsOf(const Mat4& m) {
    nb::list rows;
    for (int row = 0; row < 4; ++row) {
        nb::list one;
        for (int column = 0; column < 4; ++column) one.append(m[column][row]);
        rows.append(one);
    }
    return rows;
}

nb::dict cameraOf(const Camera& camera) {
    Mat4 wsFromCamera(camera.wsFromCamera);
    wsFromCamera[3] = {camera.wsPosition, 1.0};
    nb::dict out;
    out["type"] = camera.type == CameraType::perspective ? "perspective" : "orthographic";
    out["matrix"] = rowsOf(wsFromCamera);
    out["fov"] = camera.fov;
    out["height"] = camera.height;
    out["near"] = camera.near;
    out["resolution"] = nb::make_tuple(camera.resolution.x, camera.resolution.y);
    out["pixel_aspect"] = camera.pixelAspect;
    out["shift"] = nb::make_tuple(camera.shift.x, camera.shift.y);
    return out;
}

nb::dict resolved(const ShotObject& object, int frame) {
    const auto busy = std::make_shared<Busy>(object.state, "its scene");
    Scene scene;
    doAndWait([&](Work& work) {
        RenderOptions options;
        options.checkpoint = work.checkpoint();
        options.messages = work.messageSink();
        scene = busy->shot().scene(frame, options);
    });
    nb::dict lights, volumes, out;
    for (const Light& light : scene.lights) lights[light.name.c_str()] = listOf(light.intensity);
    for (const SceneVolume& volume : scene.volumes) {
        nb::dict one;
        one["file"] = pathObject(volume.file);
        one["matrix"] = rowsOf(volume.wsFromAsset);
        volumes[volume.name.c_str()] = one;
    }
    out["camera"] = cameraOf(scene.camera);
    out["lights"] = lights;
    out["ambient"] = listOf(scene.ambient);
    out["volumes"] = volumes;
    return out;
}

nb::dict displaysOf(const ShotObject& object) {
    const ColourConfig& colour = object.shot().colour();
    nb::dict out;
    const auto add = [&](const std::string& display) {
        nb::list views;
        const std::string first = colour.defaultView(display);
        views.append(first);
        for (const std::string& view : colour.views(display))
            if (view != first) views.append(view);
        out[display.c_str()] = views;
    };
    const std::string first = colour.defaultDisplay();
    add(first);
    for (const std::string& display : colour.displays())
        if (display != first) add(display);
    return out;
}

nb::object displayedBy(const ShotObject& object, const Floats& pixels, const std::string& display,
                       const std::string& view) {
    if (pixels.shape(2) != 4) throw Error(ErrorKind::usage, "pixels: expected an array (height, width, 4) of float32");
    const std::size_t height = pixels.shape(0), width = pixels.shape(1);
    Image image;
    image.window = {0, 0, static_cast<int>(width), static_cast<int>(height)};
    image.rgba.assign(pixels.data(), pixels.data() + pixels.size());
    const ColourConfig colour = object.shot().colour();  // may be used while the shot is at work
    doAndWait([&](Work&) { image = colour.displayed(image, display, view); });
    return ownedArray(std::move(image));
}

double valueAt(const std::vector<double>& frames, const std::vector<double>& values, double frame, bool smooth) {
    if (frames.empty() || frames.size() != values.size())
        throw Error(ErrorKind::usage, "keys: expected as many frames as values, and one of them at least");
    Keyed<double> keyed{{}, smooth ? Interpolation::smooth : Interpolation::linear};
    for (std::size_t i = 0; i < frames.size(); ++i) keyed.keys.emplace_back(frames[i], values[i]);
    return keyed.at(frame);
}

}  // namespace

nb::object ownedArray(Image picture) {
    auto image = std::make_unique<Image>(std::move(picture));
    const auto height = std::size_t(image->window.height()), width = std::size_t(image->window.width());
    float* const data = image->rgba.data();
    const nb::capsule owner(image.release(), [](void* it) noexcept { delete static_cast<Image*>(it); });
    return nb::cast(nb::ndarray<nb::numpy, float, nb::ndim<3>>(data, {height, width, std::size_t(4)}, owner));
}

void bindLooking(nb::module_& module, nb::class_<ShotObject>& type) {
    module.def("value_at", &valueAt, nb::arg("frames"), nb::arg("values"), nb::arg("frame"), nb::arg("smooth") = false,
               "The value that keys give a frame, as in scenes: `frames` ascend, and each has its number in `values`. "
               "`smooth`: by smooth curves, not linearly.");
    type.def("resolved", &resolved, nb::arg("frame") = 1,
             nb::sig("def resolved(self, frame: int = 1) -> dict[str, typing.Any]"),
             R"(The scene at a frame in plain numbers: keys evaluated, colours in the working space, paths expanded.

'camera': its 'matrix' (camera to world, as in scenes), 'fov' (horizontal, degrees), 'height' (orthographic), 'near',
'resolution', 'pixel_aspect', 'shift'.  'lights': by name, color * intensity * 2^exposure with the temperature's colour.
'ambient': a colour.  'volumes': by name, 'file' ('' where there is none) and 'matrix' (asset to world).)")
        .def_prop_ro("displays", &displaysOf, nb::sig("def displays(self) -> dict[str, list[str]]"),
                     "Displays of the colour config, each with its views. Defaults come first.")
        .def(
            "displayed", &displayedBy, nb::arg("pixels"), nb::arg("display") = "", nb::arg("view") = "",
            nb::sig("def displayed(self, pixels: numpy.typing.NDArray[numpy.float32], display: str = '', view: str = "
                    "'') -> numpy.typing.NDArray[numpy.float32]"),
            "Pixels (height, width, 4) of the working space as a view of a display shows them, before they are clamped "
            "to 0..1 and rounded. '': the defaults. Alpha stays as it is.");
}

}  // namespace scrim::python
