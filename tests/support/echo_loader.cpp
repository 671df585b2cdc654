// SPDX-License-Identifier: Apache-2.0
// Stands in for the program `scrim-load` (load_protocol.h), with children that were taken over by the files they read:
// a file holds what is to be handed over, byte by byte, and each child says that all went well.
#include <scrim/guard/load_protocol.h>

#include <algorithm>
#include <iterator>

#include <sys/socket.h>
#include <unistd.h>

namespace {

void copy(int from, int to) {
    char part[1 << 12];
    for (off_t at = 0;;) {
        const ssize_t size = ::pread(from, part, sizeof part, at);
        if (size <= 0 || ::pwrite(to, part, static_cast<std::size_t>(size), at) != size) return;
        at += size;
    }
}

}  // namespace

int main() {
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
        copy(files[scrim::kInput], files[scrim::kTransfer]);
        const scrim::LoadAnswer good;
        if (::send(files[scrim::kControl], &good, sizeof good, MSG_NOSIGNAL) < 0) return 1;
        for (const int file : files)
            if (file >= 0) ::close(file);
    }
}
