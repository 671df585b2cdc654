// SPDX-License-Identifier: Apache-2.0
// The transfer function of a classified volume as its surfaces (surface.h) look it up.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/scene/classified.h>

#include <utility>
#include <vector>

namespace scrim {

/// A transfer function prepared for whole sheets: pre-integrated classification.
///
/// While a ray crosses a sheet, the field changes from one value to another. Looking the transfer function up once
/// would show every step in it as slices of the volume, as many as there are sheets. Instead the transfer function is
/// averaged over all values that are passed, as if the field were linear between the planes of neighbouring sheets:
///     mean of s over [a, b] = (K(b) - K(a)) / (b - a),   K(f) = integral of s from 0 to f.
/// K is tabulated for the extinction s and for extinction times colour (K. Engel, M. Kraus, T.
/// Ertl, "High-quality pre-integrated volume rendering using hardware-accelerated pixel shading",
/// 2001, do so for the opacity of a sheet). It is exact if the field is linear within the sheet, so
/// its error is of second order in the thickness of a sheet even where the transfer function jumps.
class TransferTable {
  public:
    explicit TransferTable(const Classified& classified);
    ~TransferTable();

    /// Mean extinction as the field runs from a to b over the first half of the path and from b to
    /// c over the second; `count` samples each (a multiple of 16), in buffers aligned to 64 bytes.
    void meanExtinction(const Real* a, const Real* b, const Real* c, int count, Real* extinction, Simd simd = {}) const;
    /// The same for extinction times one channel of colour.
    void meanEmission(int channel, const Real* a, const Real* b, const Real* c, int count, Real* out,
                      Simd simd = {}) const;

    /// True if any value in [low, high] has extinction.
    bool anyBetween(Real low, Real high) const;
    /// True if no value in [low, high] has extinction; where it begins and ends, there is none.
    bool clear(Real low, Real high) const;
    bool clear(Real value) const { return clear(value, value); }
    /// The value at which extinction begins, on the way from a clear value to another; `other` if
    /// none does before that.
    Real edge(Real clear, Real other) const;

  private:
    struct Function;
    void mean(const Function& f, const Real* a, const Real* b, const Real* c, int count, Real* out, Simd simd) const;

    double m_cell;                                    // width in values; place i is at i * m_cell
    Real m_nothing;                                   // the place up to which there is no extinction
    std::vector<Function> m_functions;                // extinction, extinction times R, G, B
    std::vector<std::pair<double, double>> m_opaque;  // ranges of values, ascending; outside of them extinction is 0
};

}  // namespace scrim
