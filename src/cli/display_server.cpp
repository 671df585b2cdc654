// SPDX-License-Identifier: Apache-2.0
#include "display_server.h"

#include <scrim/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace scrim::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kDefaultPort = "14158";
constexpr std::chrono::milliseconds kPause{250};
constexpr int kPatience = 3000;  // milliseconds, for connecting and for each packet
constexpr int kTile = 128;       // pixels
constexpr int kChannels = 4;
// The space in which the viewer expects floats. Old configs do not have it, and those of Blender before 4.0 work in it
// without knowing its name: pictures are shown in their working space.
constexpr const char* kSpace = "lin_rec709_scene";

static_assert(std::endian::native == std::endian::little, "packets hold numbers as memory does");

/// A packet: its length, its type, and its contents.
class Packet {
  public:
    enum class Type : std::uint8_t { createImage = 4, updateImage = 6 };

    explicit Packet(Type type) {
        add(std::uint32_t(0));
        add(static_cast<std::uint8_t>(type));
    }
    template <typename Number>
    void add(Number value) {
        add(&value, 1);
    }
    template <typename Number>
    void add(const Number* values, std::size_t count) {
        const char* const first = reinterpret_cast<const char*>(values);
        m_bytes.insert(m_bytes.end(), first, first + count * sizeof(Number));
    }
    void add(const std::string& text) { add(text.c_str(), text.size() + 1); }
    const std::vector<char>& bytes() {
        const auto size = static_cast<std::uint32_t>(m_bytes.size());
        std::memcpy(m_bytes.data(), &size, sizeof size);
        return m_bytes;
    }

  private:
    std::vector<char> m_bytes;
};

void addChannels(Packet& packet) {
    packet.add(std::int32_t(kChannels));
    for (const char* channel : {"R", "G", "B", "A"}) packet.add(std::string(channel));
}

Packet createPacket(const std::string& name, const PixelWindow& window, bool grabFocus) {
    Packet packet(Packet::Type::createImage);
    packet.add(static_cast<std::uint8_t>(grabFocus));
    packet.add(name);
    packet.add(std::int32_t(window.width()));
    packet.add(std::int32_t(window.height()));
    addChannels(packet);
    return packet;
}

/// The part `box` of the image; the viewer's (0, 0) is the image's corner.
Packet updatePacket(const std::string& name, const Image& image, const PixelWindow& box) {
    Packet packet(Packet::Type::updateImage);
    packet.add(std::uint8_t(0));
    packet.add(name);
    addChannels(packet);
    for (const int number : {box.x0 - image.window.x0, box.y0 - image.window.y0, box.width(), box.height()})
        packet.add(std::int32_t(number));
    for (int c = 0; c < kChannels; ++c) packet.add(std::int64_t(c));
    for (int c = 0; c < kChannels; ++c) packet.add(std::int64_t(kChannels));
    for (int y = box.y0; y < box.y1; ++y)
        packet.add(image.rgba.data() + image.indexOf(box.x0, y), std::size_t(kChannels) * std::size_t(box.width()));
    return packet;
}

bool sameIn(const PixelWindow& box, const Image& a, const Image& b) {
    const std::size_t bytes = sizeof(float) * std::size_t(kChannels) * std::size_t(box.width());
    for (int y = box.y0; y < box.y1; ++y) {
        const std::size_t at = a.indexOf(box.x0, y);
        if (std::memcmp(a.rgba.data() + at, b.rgba.data() + at, bytes) != 0) return false;
    }
    return true;
}

/// A connection that gives up when the other end receives nothing for kPatience.
class Connection {
  public:
    explicit Connection(const std::string& address);
    ~Connection() { ::close(m_socket); }
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    /// Returns a problem, or "" if everything was sent.
    std::string send(const std::vector<char>& bytes) const;

  private:
    static bool ready(int socket, short events) {
        pollfd wait{socket, events, 0};
        return ::poll(&wait, 1, kPatience) == 1;
    }
    static int connectTo(const addrinfo& to, int& error);

    int m_socket = -1;
};

int Connection::connectTo(const addrinfo& to, int& error) {
    const int socket = ::socket(to.ai_family, to.ai_socktype | SOCK_CLOEXEC | SOCK_NONBLOCK, to.ai_protocol);
    error = errno;
    if (socket < 0) return -1;
    error = ::connect(socket, to.ai_addr, to.ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS) {
        error = ETIMEDOUT;
        socklen_t size = sizeof error;
        if (ready(socket, POLLOUT)) ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
    }
    if (error == 0) return socket;
    ::close(socket);
    return -1;
}

Connection::Connection(const std::string& address) {
    const std::size_t colon = address.rfind(':');
    const std::string given = address.substr(0, colon);
    const std::string host = given.empty() ? "127.0.0.1" : given;
    const std::string port = colon == std::string::npos ? kDefaultPort : address.substr(colon + 1);
    const bool isNumber =
        !port.empty() && port.size() <= 5 && port.find_first_not_of("0123456789") == std::string::npos;
    if (!isNumber || std::stoi(port) < 1 || std::stoi(port) > 65535)
        throw Error(ErrorKind::usage, fmt::format("--display-server '{}': expected HOST:PORT, such as 127.0.0.1:{}",
                                                  shortened(address, 80), kDefaultPort));
    addrinfo hints{}, *found = nullptr;
    hints.ai_socktype = SOCK_STREAM;
    const int failed = ::getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
    std::string reason = failed != 0 ? ::gai_strerror(failed) : "";
    for (const addrinfo* to = found; failed == 0 && to != nullptr && m_socket < 0; to = to->ai_next) {
        int error = 0;
        m_socket = connectTo(*to, error);
        reason = std::strerror(error);
    }
    if (failed == 0) ::freeaddrinfo(found);
    if (m_socket < 0)
        throw Error(ErrorKind::output,
                    fmt::format("--display-server {}:{}: no viewer answers: {}", shortened(host, 80), port, reason));
}

std::string Connection::send(const std::vector<char>& bytes) const {
    for (std::size_t sent = 0; sent < bytes.size();) {
        const ssize_t n = ::send(m_socket, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
        if (n > 0) {
            sent += static_cast<std::size_t>(n);
        } else if (n < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) {
            return std::strerror(errno);
        } else if (!ready(m_socket, POLLOUT)) {
            return "the viewer stopped reading";
        }
    }
    return "";
}

}  // namespace

struct DisplayServer::Sender {
    /// A picture, complete or in progress.
    struct Shown {
        std::string name;
        ColourConfig colours;
        Image image;
    };

    explicit Sender(const std::string& address) : connection(address), thread([this] { run(); }) {}
    ~Sender() {
        {
            const std::lock_guard lock(mutex);
            ends = true;
        }
        changed.notify_all();
        thread.join();
    }

    void give(Shown shown) {
        {
            const std::lock_guard lock(mutex);
            if (!problem.empty()) return;
            // A waiting picture is replaced, unless it is the last state of another picture.
            if (!waiting.empty() && waiting.back().name == shown.name) waiting.pop_back();
            waiting.push_back(std::move(shown));
        }
        changed.notify_all();
    }
    void run();
    std::string send(Shown& shown);

    Connection connection;
    mutable std::mutex mutex;
    std::condition_variable changed;
    std::vector<Shown> waiting;
    std::string problem;
    bool ends = false;

    // Used by the sending thread only.
    std::string sentName;
    Image sent;
    bool first = true;

    // Used by the rendering thread only.
    std::string name;
    std::optional<ColourConfig> colours;
    Clock::time_point asked;

    std::thread thread;
};

void DisplayServer::Sender::run() {
    std::unique_lock lock(mutex);
    for (;;) {
        changed.wait(lock, [&] { return ends || !waiting.empty(); });
        if (waiting.empty() || !problem.empty()) {
            if (ends) return;
            waiting.clear();
            continue;
        }
        Shown shown = std::move(waiting.front());
        waiting.erase(waiting.begin());
        lock.unlock();
        std::string failed;
        try {
            failed = send(shown);
        } catch (const std::exception& error) {
            failed = error.what();
        }
        lock.lock();
        if (!failed.empty()) problem = failed;
    }
}

std::string DisplayServer::Sender::send(Shown& shown) {
    Image& image = shown.image;
    if (shown.colours.hasSpace(kSpace)) shown.colours.convert(image, shown.colours.workingSpace(), kSpace);
    const PixelWindow window = image.window;
    const bool isNew = shown.name != sentName || !(window == sent.window);
    if (isNew) {
        const std::string failed = connection.send(createPacket(shown.name, window, first).bytes());
        if (!failed.empty()) return failed;
        sent = emptyImage(window);
        sentName = shown.name;
        first = false;
    }
    for (int y = window.y0; y < window.y1; y += kTile)
        for (int x = window.x0; x < window.x1; x += kTile) {
            const PixelWindow box{x, y, std::min(x + kTile, window.x1), std::min(y + kTile, window.y1)};
            if (sameIn(box, image, sent)) continue;
            const std::string failed = connection.send(updatePacket(shown.name, image, box).bytes());
            if (!failed.empty()) return failed;
        }
    sent = std::move(image);
    return "";
}

DisplayServer::DisplayServer(const std::string& address) : m_sender(std::make_unique<Sender>(address)) {}
DisplayServer::~DisplayServer() = default;

void DisplayServer::begin(const std::string& name, const ColourConfig& colours) {
    m_sender->name = name;
    m_sender->colours = colours;
    m_sender->asked = Clock::now();
}

PictureSink DisplayServer::sink() {
    return [this](const std::function<Image()>& soFar) {
        Sender& sender = *m_sender;
        if (Clock::now() - sender.asked < kPause || !problem().empty()) return;
        sender.give({sender.name, *sender.colours, soFar()});
        sender.asked = Clock::now();
    };
}

void DisplayServer::finish(const Image& image) {
    m_sender->give({m_sender->name, *m_sender->colours, image});
}

std::string DisplayServer::problem() const {
    const std::lock_guard lock(m_sender->mutex);
    return m_sender->problem;
}

}  // namespace scrim::cli
