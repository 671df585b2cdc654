// SPDX-License-Identifier: Apache-2.0
#include <scrim/guard/load_request.h>

#include <scrim/guard/transfer_file.h>

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

namespace scrim {
namespace {

/// Writes the members of tasks, one after the other.
class Sending {
  public:
    explicit Sending(TransferWriter& writer) : m_writer(writer) {}

    void operator()(std::string& text) const { m_writer.text(text); }
    void operator()(GridEdit& edit) const { m_writer.text(toText(edit)); }
    void operator()(GridRequest& request) const { m_writer.text(toText(request)); }
    void operator()(std::pair<std::string, std::string>& parameter) const {
        m_writer.text(parameter.first);
        m_writer.text(parameter.second);
    }
    template <typename T>
    void operator()(std::vector<T>& values) const {
        m_writer.value(std::uint64_t{values.size()});
        for (T& value : values) (*this)(value);
    }
    template <typename T>
    void operator()(std::optional<T>& value) const {
        m_writer.value(std::uint8_t{value.has_value()});
        if (value) (*this)(*value);
    }
    template <typename Parts>
    requires requires(Parts parts) { parts.members(); }
    void operator()(Parts& parts) const {
        std::apply([this](auto&... member) { ((*this)(member), ...); }, parts.members());
    }

  private:
    TransferWriter& m_writer;
};

/// Reads what Sending wrote.
class Receiving {
  public:
    explicit Receiving(TransferReader& reader) : m_reader(reader) {}

    void operator()(std::string& text) const { text = m_reader.text(); }
    void operator()(GridEdit& edit) const { edit = gridEditFrom(m_reader.text()); }
    void operator()(GridRequest& request) const { request = gridRequestFrom(m_reader.text()); }
    void operator()(std::pair<std::string, std::string>& parameter) const {
        parameter.first = m_reader.text();
        parameter.second = m_reader.text();
    }
    template <typename T>
    void operator()(std::vector<T>& values) const {
        for (auto left = m_reader.value<std::uint64_t>(); left > 0; --left) (*this)(values.emplace_back());
    }
    template <typename T>
    void operator()(std::optional<T>& value) const {
        if (m_reader.value<std::uint8_t>() != 0) (*this)(value.emplace());
    }
    template <typename Parts>
    requires requires(Parts parts) { parts.members(); }
    void operator()(Parts& parts) const {
        std::apply([this](auto&... member) { ((*this)(member), ...); }, parts.members());
    }

  private:
    TransferReader& m_reader;
};

/// The task of kind `index`, with nothing in it.
template <std::size_t I = 0>
LoadTask taskOfKind(std::uint32_t index) {
    if constexpr (I < std::variant_size_v<LoadTask>) {
        if (index == I) return LoadTask(std::in_place_index<I>);
        return taskOfKind<I + 1>(index);
    } else {
        incompleteTransfer("it asks for something unknown");
    }
}

}  // namespace

const LoadEdit* editOf(const LoadTask& task) {
    return std::visit(
        [](const auto& one) -> const LoadEdit* {
            using Task = std::decay_t<decltype(one)>;
            if constexpr (std::is_same_v<Task, FieldsTask> || std::is_same_v<Task, InfoTask>)
                return one.edit ? &*one.edit : nullptr;
            else if constexpr (std::is_same_v<Task, EditedFileTask> || std::is_same_v<Task, MadeFieldsTask>)
                return &one.edit;
            else
                return nullptr;
        },
        task);
}

void sendRequest(int fd, const LoadRequest& request) {
    TransferWriter writer(fd);
    writer.text(request.path);
    writer.value(static_cast<std::uint32_t>(request.task.index()));
    LoadTask task = request.task;
    std::visit(Sending(writer), task);
    writer.finish({}, TransferKind::request);
}

LoadRequest receiveRequest(int fd) {
    const TransferMapping mapping(fd, TransferMapping::Sender::trusted);
    TransferReader reader(mapping);
    reader.header(TransferKind::request);
    LoadRequest out;
    out.path = reader.text();
    out.task = taskOfKind(reader.value<std::uint32_t>());
    std::visit(Receiving(reader), out.task);
    return out;
}

}  // namespace scrim
