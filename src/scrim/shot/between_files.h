// SPDX-License-Identifier: Apache-2.0
// Fields at a moment between two files of a sequence, as slow motion needs them: both files are mixed, after each was
// carried to the moment by its own velocity (semi-Lagrangian, backwards, by the midpoint rule). Voxels appear and
// vanish as they do in the files. See examples/guide/slow-motion.md.
#pragma once

#include <scrim/shot/derived_fields.h>

#include <array>
#include <memory>
#include <set>
#include <vector>

namespace scrim {

/// A moment between two files.
struct BetweenMoment {
    double part = 0;  ///< 0 at the first file, 1 at the second
    double time = 0;  ///< from file to file fields move by time * velocity, in world units of the asset
    /// For each file the fields of its velocity, as FieldMover takes them; empty: nothing is carried.
    std::array<std::vector<FieldPointer>, 2> velocity = {};

    bool operator==(const BetweenMoment&) const = default;
};

/// Makes the fields of a volume at one moment.
class BetweenFields {
  public:
    explicit BetweenFields(BetweenMoment moment);
    ~BetweenFields();

    const BetweenMoment& moment() const { return m_moment; }

    /// (1 - part) * (first at the moment) + part * (second at the moment), on the lattice of
    /// `first`, or that of `second` where `first` is empty. Throws Error(memory) where constant
    /// regions are too large for voxels of their own.
    FieldPointer at(const FieldPointer& first, const FieldPointer& second) const;

  private:
    class Side;
    BetweenMoment m_moment;
    std::vector<Side> m_sides;
};

/// Keeps the fields that were made, as long as the next frame needs them, too.
class BetweenStore {
  public:
    FieldPointer at(const BetweenFields& fields, const FieldPointer& first, const FieldPointer& second);
    /// Forgets what was not asked for since the last call.
    void forgetUnused();
    /// Forgets what was made from other fields than these, which it would hold in memory.
    void keepOnly(const std::set<FieldPointer>& sources);

  private:
    struct Made {
        bool isOf(const std::set<FieldPointer>& sources) const;

        BetweenMoment moment;
        FieldPointer first, second, field;
        bool used = true;
    };
    std::vector<Made> m_all;
};

}  // namespace scrim
