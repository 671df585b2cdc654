// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/exr_header.h>

#include <scrim/base/system_error.h>

#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfRationalAttribute.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <cerrno>

namespace scrim {

namespace {

constexpr float kDwaLevel = 45.0f;  // OpenEXR's own default, written down because it decides the loss

struct InsertAttribute {
    Imf::Header& header;
    const std::string& name;

    void operator()(const std::string& text) const { header.insert(name, Imf::StringAttribute(text)); }
    void operator()(double value) const { header.insert(name, Imf::FloatAttribute(static_cast<float>(value))); }
    void operator()(int value) const { header.insert(name, Imf::IntAttribute(value)); }
    void operator()(const glm::dmat4& matrix) const {
        // GLM's [column][row] of a matrix for column vectors equals EXR's [row][column] of one for row vectors.
        Imath::M44f rows;
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) rows[i][j] = static_cast<float>(matrix[i][j]);
        header.insert(name, Imf::M44fAttribute(rows));
    }
    void operator()(const FrameRate& rate) const {
        header.insert(name, Imf::RationalAttribute(Imf::Rational(rate.numerator, static_cast<int>(rate.denominator))));
    }
};

}  // namespace

CheckedStream::CheckedStream(const std::string& path) : Imf::OStream(path.c_str()) {
    errno = 0;  // so that `check` does not see an older error
    m_file.open(path, std::ios::binary | std::ios::trunc);
    check();
}

void CheckedStream::write(const char bytes[], int count) {
    errno = 0;
    m_file.write(bytes, count);
    check();
}

void CheckedStream::seekp(uint64_t position) {
    errno = 0;
    m_file.seekp(static_cast<std::streamoff>(position));
    check();
}

void CheckedStream::close() {
    errno = 0;
    m_file.close();
    check();
}

void CheckedStream::check() {
    if (m_error == 0 && !m_file) m_error = errno != 0 ? errno : EIO;
    if (m_error != 0) throw std::runtime_error(systemErrorText(m_error));
}

const std::vector<std::string>& exrCompressions() {
    static const std::vector<std::string> names = {"zip", "zips", "piz", "dwaa", "none"};
    return names;
}

Imf::Compression exrCompressionNamed(const std::string& name) {
    if (name == "zip") return Imf::ZIP_COMPRESSION;
    if (name == "zips") return Imf::ZIPS_COMPRESSION;
    if (name == "piz") return Imf::PIZ_COMPRESSION;
    if (name == "dwaa") return Imf::DWAA_COMPRESSION;
    if (name == "none") return Imf::NO_COMPRESSION;
    throw Error(ErrorKind::usage,
                fmt::format("unknown EXR compression '{}'; expected {}", shortened(name), choices(exrCompressions())));
}

Imath::Box2i closedBox(const PixelWindow& window) {
    return {{window.x0, window.y0}, {window.x1 - 1, window.y1 - 1}};
}

Imf::Header makeExrHeader(const PixelWindow& dataWindow, const ExrOptions& options, const ExrAttributes& attributes) {
    const Imf::Compression compression = exrCompressionNamed(options.compression);
    Imf::Header header(closedBox(options.displayWindow), closedBox(dataWindow), static_cast<float>(options.pixelAspect),
                       Imath::V2f(0, 0), 1, Imf::INCREASING_Y,
                       options.acesContainer ? Imf::NO_COMPRESSION : compression);
    if (compression == Imf::DWAA_COMPRESSION) header.dwaCompressionLevel() = kDwaLevel;
    if (!options.colorInteropId.empty()) header.insert("colorInteropID", Imf::StringAttribute(options.colorInteropId));
    if (options.chromaticities) {
        const Chromaticities& c = *options.chromaticities;
        Imf::addChromaticities(header, Imf::Chromaticities({c[0], c[1]}, {c[2], c[3]}, {c[4], c[5]}, {c[6], c[7]}));
    }
    if (options.acesContainer) header.insert("acesImageContainerFlag", Imf::IntAttribute(1));
    for (const auto& [name, value] : attributes) std::visit(InsertAttribute{header, name}, value);
    return header;
}

}  // namespace scrim
