// SPDX-License-Identifier: Apache-2.0
// Shows pictures while they are rendered in a viewer that listens: tev, by its protocol over TCP. A separate thread
// sends, so that a slow viewer delays nothing but its own display.
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
    /// Waits until everything is sent, or the viewer stops receiving.
    ~DisplayServer();
    DisplayServer(const DisplayServer&) = delete;
    DisplayServer& operator=(const DisplayServer&) = delete;

    /// Begins a picture, which the viewer knows by `name`. Must be called before the two below.
    void begin(const std::string& name, const ColourConfig& colours);
    /// For RenderOptions::shown: asks for the picture four times a second, and sends the parts that have changed.
    PictureSink sink();
    /// Sends the final picture.
    void finish(const Image& image);

    /// Why nothing is shown any more; "" if there is no problem. After a problem nothing here has any effect.
    std::string problem() const;

  private:
    struct Sender;
    std::unique_ptr<Sender> m_sender;
};

}  // namespace scrim::cli
