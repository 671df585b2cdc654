// SPDX-License-Identifier: Apache-2.0
// Stands in for the program `scrim-load` (load_protocol.h), with children that were taken over by the files they read:
// a file holds what is to be handed over, byte by byte, and each child says that all went well. Where a file begins
// with kWithAnother, its child waits for a second such file.
#include <scrim/guard/load_protocol.h>

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

#include <sys/socket.h>
#include <unistd.h>

namespace {

constexpr std::string_view kWithAnother = "with another\n";

bool waitsForAnother(int file) {
    char start[kWithAnother.size()];
    return ::pread(file, start, sizeof start, 0) == sizeof start &&
           kWithAnother == std::string_view(start, sizeof start);
}

void copy(int from, int to, off_t begin) {
    char part[1 << 12];
    for (off_t at = 0;;) {
        const ssize_t size = ::pread(from, part, sizeof part, begin + at);
        if (size <= 0 || ::pwrite(to, part, static_cast<std::size_t>(size), at) != size) return;
        at += size;
    }
}

bool answer(int control) {
    const scrim::LoadAnswer good;
    const bool sent = ::send(control, &good, sizeof good, MSG_NOSIGNAL) >= 0;
    ::close(control);
    return sent;
}

}  // namespace

int main() {
    int waiting = -1;  // the control of a child that waits for another
    for (;;) {
        scrim::LoadMessage message;
        iovec text{&message, sizeof message};
        int files[scrim::kMostDescriptors];
        std::fill(std::begin(files), std::end(files), -1);
        alignas(cmsghdr) char space[CMSG_SPACE(sizeof files)];
        msghdr head{};
        head.msg_iov = &text;
        head.msg_iovlen = 1;
        head.msg_control = space;
        head.msg_controllen = sizeof space;
        if (::recvmsg(scrim::kLoadSocket, &head, 0) <= 0) return 0;
        const cmsghdr* rights = CMSG_FIRSTHDR(&head);
        if (rights == nullptr) return 1;
        const auto* from = reinterpret_cast<const int*>(CMSG_DATA(rights));
        for (unsigned i = 0; i < message.descriptors; ++i) files[i] = from[i];
        if (::ftruncate(files[scrim::kTransfer], 0) != 0) return 1;
        const bool waits = waitsForAnother(files[scrim::kInput]);
        copy(files[scrim::kInput], files[scrim::kTransfer], waits ? off_t{kWithAnother.size()} : 0);
        const int control = files[scrim::kControl];
        for (const int file : files)
            if (file >= 0 && file != control) ::close(file);
        if (waits && waiting < 0) {
            waiting = control;
            continue;
        }
        if (waiting >= 0) answer(std::exchange(waiting, -1));
        if (!answer(control)) return 1;
    }
}
