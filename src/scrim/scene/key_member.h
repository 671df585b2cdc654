// SPDX-License-Identifier: Apache-2.0
// The member of a struct that a key of a scene sets.
#pragma once

#include <functional>
#include <stdexcept>
#include <type_traits>
#include <typeinfo>

namespace scrim {

/// What leads to a member of an Object: &Object::name, or a function that returns a reference to a
/// member of an Object, which may be const.
template <typename Member, typename Object>
concept MemberOf = std::is_invocable_v<Member, Object&>;

/// Leads to a member of a member: within(&Scene::camera, &Camera::fov).
template <typename Outer, typename Inner>
auto within(Outer outer, Inner inner) {
    return [=](auto& object) -> auto& {
        return std::invoke(inner, std::invoke(outer, object));
    };
}

/// A number, whole number, boolean or enumeration in a struct, read and set as a number: a boolean
/// is 0 or 1, and an enumeration is the index of its word.
class KeyMember {
  public:
    KeyMember() = default;

    /// A boolean is true where its number is `yes`.
    template <typename Object, MemberOf<Object> Member>
    static KeyMember of(Member member, int yes = 1);

    /// False for a key that sets no such member.
    explicit operator bool() const { return m_type != nullptr; }
    /// The object must be of the type that the member is of.
    template <typename Object>
    double get(const Object& object) const {
        require(typeid(Object));
        return m_get(&object);
    }
    template <typename Object>
    void set(Object& object, double number) const {
        require(typeid(Object));
        m_set(&object, number);
    }

  private:
    void require(const std::type_info& type) const {
        if (m_type == nullptr || *m_type != type) throw std::logic_error("a key sets a member of another type");
    }

    const std::type_info* m_type = nullptr;
    std::function<double(const void*)> m_get;
    std::function<void(void*, double)> m_set;
};

template <typename Object, MemberOf<Object> Member>
KeyMember KeyMember::of(Member member, int yes) {
    using Value = std::remove_cvref_t<std::invoke_result_t<Member, Object&>>;
    KeyMember out;
    out.m_type = &typeid(Object);
    out.m_get = [=](const void* object) {
        const Value value = std::invoke(member, *static_cast<const Object*>(object));
        if constexpr (std::is_same_v<Value, bool>)
            return double(value ? yes : 1 - yes);
        else
            return static_cast<double>(value);
    };
    out.m_set = [=](void* object, double number) {
        auto& value = std::invoke(member, *static_cast<Object*>(object));
        if constexpr (std::is_same_v<Value, bool>)
            value = number == yes;
        else if constexpr (std::is_enum_v<Value>)
            value = static_cast<Value>(static_cast<int>(number));
        else
            value = static_cast<Value>(number);
    };
    return out;
}

}  // namespace scrim
