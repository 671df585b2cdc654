// SPDX-License-Identifier: Apache-2.0
// Rendered frames as Python sees them. Pictures are arrays that share the frame's memory.
#include "bindings.h"

#include <scrim/shot/shot_frame.h>

#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

namespace scrim::python {
namespace {

using Picture = nb::ndarray<nb::numpy, const float, nb::ndim<3>, nb::c_contig>;

/// The name of the beauty in `frame[...]`. No layer has this name.
constexpr const char* kBeauty = "beauty";

/// A view of `data`; the array keeps the frame alive.
Picture pictureOf(nb::handle frame, const std::vector<float>& data, std::size_t channels) {
    const PixelWindow& window = nb::cast<const ShotFrame&>(frame).image().window;
    return Picture(data.data(), {std::size_t(window.height()), std::size_t(window.width()), channels}, frame);
}

Picture beautyOf(nb::handle self) {
    return pictureOf(self, nb::cast<const ShotFrame&>(self).image().rgba, 4);
}

Picture layerOf(nb::handle self, nb::handle layer) {
    const std::string name = textOf(layer, "the name of a layer");
    if (name == kBeauty) return beautyOf(self);
    const ShotLayer& found = nb::cast<const ShotFrame&>(self).layer(name);
    return pictureOf(self, found.data, found.channels.size());
}

std::vector<std::string> channelsOf(const ShotFrame& frame, nb::handle layer) {
    const std::string name = textOf(layer, "the name of a layer");
    if (name == kBeauty) return {"R", "G", "B", "A"};
    return frame.layer(name).channels;
}

/// Releases the interpreter's lock while writing, which may take seconds.
template <typename Write>
void write(nb::handle path, const Write& write) {
    const std::string name = path.is_none() ? "" : pathText(path);
    doAndWait([&](Work& work) { write(name, work.messageSink()); });
}

nb::object backplateOf(const ShotFrame& frame) {
    Image plate;
    doAndWait([&](Work&) { plate = frame.backplate(); });
    return plate.rgba.empty() ? nb::none() : ownedArray(std::move(plate));
}

std::optional<double> errorOf(const ShotFrame& frame) {
    const auto& verification = frame.report().verification;
    return verification ? std::optional(verification->error) : std::nullopt;
}

/// The pixels that were compared with brute force, as arrays; None where there are none.
nb::object examinedOf(const ShotFrame& frame) {
    const auto& verification = frame.report().verification;
    if (!verification) return nb::none();
    const std::vector<ExaminedPixel>& all = verification->examined;
    const nb::object array = nb::module_::import_("numpy").attr("array");
    const auto made = [&](const char* type, std::size_t width, const auto& rowOf) {
        nb::list rows;
        for (const ExaminedPixel& pixel : all) rows.append(rowOf(pixel));
        return array(rows, type).attr("reshape")(all.size(), width);
    };
    const auto rgba = [](const std::array<double, 4>& v) { return nb::make_tuple(v[0], v[1], v[2], v[3]); };
    nb::dict out;
    out["place"] = made("int32", 2, [](const ExaminedPixel& p) { return nb::make_tuple(p.x, p.y); });
    out["picture"] = made("float64", 4, [&](const ExaminedPixel& p) { return rgba(p.rendered); });
    out["truth"] = made("float64", 4, [&](const ExaminedPixel& p) { return rgba(p.reference); });
    return out;
}

void requireAccuracy(const ShotFrame& frame) {
    const ShotReport& r = frame.report();
    const auto text = [](double number) { return nb::cast<std::string>(nb::str("{:.3g}").attr("format")(number)); };
    const std::string which = "frame " + std::to_string(r.frame) + ": ";
    if (r.scattering && !r.scattering->converged)
        throw Error(ErrorKind::accuracy,
                    which + "further sweeps would have changed the light that scatters more than once by about " +
                        text(r.scattering->error) + ", more than render.scatter_error = " + text(r.scattering->wanted));
    if (r.tolerance && !r.tolerance->met)
        throw Error(ErrorKind::accuracy, which + "its error may be " + text(r.tolerance->bound) +
                                             ", more than the tolerance of " + text(r.tolerance->wanted));
}

}  // namespace

nb::object toPython(ShotFrame frame) {
    if (frame.skipped()) return nb::none();
    return nb::cast(std::move(frame));
}

void bindFrames(nb::module_& module) {
    nb::class_<ShotFrame>(module, "Frame", R"(A rendered frame: its picture, its layers, and what it took.

`frame["light.key"]` is a layer, `frame["beauty"]` the picture itself: float32 of shape (height, width, channels), rows
from top to bottom, premultiplied and scene-linear in the working space. Arrays are views of the frame's memory, which
they keep; they cannot be written to: copy what you want to change.)")
        .def_prop_ro("image", &beautyOf, nb::sig("def image(self) -> numpy.typing.NDArray[numpy.float32]"),
                     "The picture: (height, width, 4), R, G, B, A. With its overscan, or the crop.")
        .def("__getitem__", &layerOf, nb::arg("layer"),
             nb::sig("def __getitem__(self, layer: str) -> numpy.typing.NDArray[numpy.float32]"),
             "A layer: (height, width, channels). Raises UsageError, which lists the names, where there is none.")
        .def_prop_ro("layers", &ShotFrame::layerNames,
                     "Names of the pictures beside the beauty, in the scene's order: of lights one each, 'light.key'.")
        .def("channels", &channelsOf, nb::arg("layer"), nb::sig("def channels(self, layer: str) -> list[str]"),
             "Names of a layer's channels, as in the file: 'light.key.R'.\n\nThe layer 'depth' holds world units along "
             "the viewing axis (Z, and the mean), 'motion' pixels a frame, to the right and up.")
        .def_prop_ro(
            "window",
            [](const ShotFrame& frame) {
                const PixelWindow& w = frame.image().window;
                return std::make_tuple(w.x0, w.y0, w.x1, w.y1);
            },
            "Where the picture lies in the display window: x0, y0, x1, y1 in pixels, half-open, y down.")
        .def_prop_ro(
            "number", [](const ShotFrame& frame) { return frame.report().frame; }, "Which frame it is.")
        .def_prop_ro(
            "stats", [](const ShotFrame& frame) { return fromJson(reportAsJson(frame.report())); },
            nb::sig("def stats(self) -> dict[str, typing.Any]"),
            "Seconds, counts of work, memory in bytes, the plan, and the verification: what `--stats` writes.")
        .def_prop_ro("error", &errorOf,
                     "Relative RMSE against brute force, where the frame was rendered with `verify` or a tolerance; "
                     "else None. `stats['verification']` has its 95 % interval and the worst pixel.")
        .def_prop_ro("examined", &examinedOf,
                     nb::sig("def examined(self) -> dict[str, numpy.typing.NDArray[typing.Any]] | None"),
                     "The pixels that counted in a verification, in the order in which they were drawn: 'place' (n, "
                     "2), x and y in the display window; 'picture' and 'truth' (n, 4), premultiplied R, G, B, A in the "
                     "working space. None where the frame was not verified.")
        .def(
            "require_accuracy", &requireAccuracy,
            "Raises AccuracyError where the frame's tolerance, or the convergence of scattered light, was not reached.")
        .def(
            "write",
            [](ShotFrame& frame, nb::handle path) {
                write(path, [&](const std::string& name, const MessageSink& sink) { frame.write(name, sink); });
                return pathObject(frame.report().file);
            },
            nb::arg("path") = nb::none(), nb::sig("def write(self, path: str | os.PathLike[str] | None = None) -> str"),
            "Writes picture and layers as one OpenEXR file with all metadata, in the space and type that the scene's "
            "[output] says.\n\n'####' in `path` stands for the frame; None: the scene's own file. The file appears "
            "whole or not at all. Returns its path.")
        .def(
            "write_deep",
            [](ShotFrame& frame, nb::handle path) {
                write(path, [&](const std::string& name, const MessageSink& sink) { frame.writeDeep(name, sink); });
            },
            nb::arg("path") = nb::none(),
            nb::sig("def write_deep(self, path: str | os.PathLike[str] | None = None) -> None"),
            "Writes the deep picture that the scene's `output.deep` asks for; otherwise as `write`.")
        .def(
            "preview",
            [](ShotFrame& frame, nb::handle path) {
                write(path, [&](const std::string& name, const MessageSink&) { frame.preview(name); });
            },
            nb::arg("path") = nb::none(),
            nb::sig("def preview(self, path: str | os.PathLike[str] | None = None) -> None"),
            "Writes the picture as a display shows it: a PNG, or what the name ends in. None: the scene's preview.")
        .def_prop_ro("backplate", &backplateOf,
                     nb::sig("def backplate(self) -> numpy.typing.NDArray[numpy.float32] | None"),
                     "What previews are laid over: (height, width, 4), premultiplied R, G, B, A in the working space, "
                     "stretched to the display window. None where the scene's preview has no backplate.")
        .def("__repr__", [](const ShotFrame& frame) {
            const PixelWindow& w = frame.image().window;
            return "<scrim.Frame " + std::to_string(frame.report().frame) + ", " + std::to_string(w.width()) + "x" +
                   std::to_string(w.height()) + ">";
        });
}

}  // namespace scrim::python
