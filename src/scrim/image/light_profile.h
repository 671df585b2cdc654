// SPDX-License-Identifier: Apache-2.0
// How much light a luminaire sends into each direction, from a photometric file (IES LM-63): the
// file as it is read, and the table in which renderers look directions up.
#pragma once

#include <scrim/geometry/spaces.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace scrim {

/// A photometric file of type C: its angles in degrees, ascending, and for each horizontal angle the candelas at all
/// vertical ones. Vertical angles count from the direction straight down, where a luminaire hangs upright.
struct FilePhotometry {
    std::vector<float> vertical, horizontal, candela;
    std::string problem;  ///< why there are no candelas, with path and line in front; "": there are
};

/// Most angles of either kind in a file, and most candelas.
inline constexpr std::size_t kMostProfileAngles = 7201, kMostCandelas = std::size_t{4} << 20;

/// Largest candela value.
inline constexpr float kMostCandela = 1e30f;

/// Largest photometric file that is read, bytes.
inline constexpr std::size_t kMostProfileBytes = std::size_t{64} << 20;

/// Reads the text of a file in the format of LM-63 of 1986, 1991, 1995, 2002 or 2019. `path` is for messages. The
/// factors of TILT=INCLUDE, for lamps whose light depends on how the luminaire is mounted, are checked and not applied.
FilePhotometry parsePhotometry(std::string_view text, const std::string& path);

/// Reads the file at `path`, or the regular file that is open as `descriptor`; `path` is then for messages alone.
FilePhotometry readPhotometry(const std::string& path, int descriptor = -1);

/// The candelas over all directions, relative to the largest of them. Between the file's angles they are bilinear in
/// the angles; beyond its vertical angles there is no light. Horizontal angles that reach to 90 or 180 degrees, or from
/// 90 to 270, are mirrored as LM-63 has it; a single one stands for all. Immutable: any number of threads may read it.
class LightProfile {
  public:
    /// `file` has no problem.
    explicit LightProfile(const FilePhotometry& file);

    /// The light sent into a direction, from 0 to 1. `direction` is unit, in the frame of the light (lightFrame): x to
    /// the right, y up, z along its axis, the file's vertical angle 0. The horizontal angle is 0 below the axis (-y)
    /// and 90 degrees to its right (+x), as Cycles has it.
    double at(const Vec3& direction) const;

    /// The largest vertical angle at which there is light, degrees.
    double reach() const { return m_reach; }
    std::size_t bytes() const { return m_values.size() * sizeof(float); }

    /// The table: `rows` rows from vertical angle 0 to 180, each with `columns` values from horizontal angle 0 to 360.
    int rows() const { return m_rows; }
    int columns() const { return m_columns; }
    const float* values() const { return m_values.data(); }
    /// The file's first and last vertical angle, degrees.
    double first() const { return m_first; }
    double last() const { return m_last; }

  private:
    int m_rows, m_columns;
    double m_first, m_last, m_reach = 0;
    std::vector<float> m_values;
};

}  // namespace scrim
