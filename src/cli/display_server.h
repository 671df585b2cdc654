// SPDX-License-Identifier: Apache-2.0
// Shows pictures while they are made in a viewer that listens: tev, by its protocol over TCP. A thread of its own
// sends, so that a slow viewer holds up nothing but what it shows.
#pragma once

#include <scrim/image/colour.h>
#include <scrim/image/image.h>

#include <memory>
#include <string>

namespace scrim::cli {

class DisplayServer {
  public:
    /// Connects to "HOST:PORT", "HOST" (port 14158) or ":PORT" (this machine). Throws Error: usage, output.
    explicit DisplayServer(const std::string& address);
    /// Waits until what was shown is sent, or the viewer does not take it.
    ~DisplayServer();
    DisplayServer(const DisplayServer&) = delete;
    DisplayServer& operator=(const DisplayServer&) = delete;

    /// Begins a picture, which the viewer knows by `name`. Before the two below.
    void begin(const std::string& name, const ColourConfig& colours);
    /// For RenderOptions::shown: asks for the picture four times a second, and shows what of it has changed.
    PictureSink sink();
    /// The picture as it will be.
    void finish(const Image& image);

    /// Why nothing is shown any more; "": it is. Then everything here does nothing.
    std::string problem() const;

  private:
    struct Sender;
    std::unique_ptr<Sender> m_sender;
};

}  // namespace scrim::cli
