// SPDX-License-Identifier: Apache-2.0
// Brightness that changes while the shutter is open. A picture is linear in it: a moment that has its mean over the
// time that the moment stands for shows a flash between two moments, and needs no more of them than a steady light.
#pragma once

#include <scrim/shot/load_shot.h>

#include <vector>

namespace scrim {

class KeyedLight {
  public:
    /// Nothing changes.
    KeyedLight() = default;
    /// Of the shot's lights, ambient light and emission from `open` to `close`, frames after the shot's frame.
    KeyedLight(const LoadedShot& shot, double open, double close);

    /// Gives a scene of the shot the means over times from `from` to `to`, of those that change at all.
    void average(double from, double to, Scene& scene) const;

  private:
    double m_open = 0, m_close = 0;
    std::vector<std::vector<double>> m_values;  // at moments one after the other; empty: nothing changes
};

}  // namespace scrim
