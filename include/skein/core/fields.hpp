// One description of every scene key. A spec struct lists its members once, in `void fields(FieldVisitor&)`. Visitors
// read them from a scene file, print them into the reference page, or echo them as JSON. Names of keys stand nowhere
// else.
#pragma once

#include "skein/core/vec3.hpp"

#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// Name, unit and meaning of one key, and the values it accepts.
struct Field {
    std::string_view name;
    std::string_view unit; ///< SI, "" for text, "-" for a pure number
    std::string_view text;
    bool required = false;
    double above = -std::numeric_limits<double>::infinity(); ///< value must be > above
    double at_least = -std::numeric_limits<double>::infinity();
    double at_most = std::numeric_limits<double>::infinity();
    double automatic =
        std::numeric_limits<double>::quiet_NaN(); ///< value of the word "auto"; not a number: no such word

    bool takes_auto() const { return !std::isnan(automatic); }
};

class FieldVisitor {
public:
    virtual ~FieldVisitor() = default;

    virtual void visit(const Field&, double&) = 0;
    virtual void visit(const Field&, long&) = 0;
    virtual void visit(const Field&, bool&) = 0;
    virtual void visit(const Field&, std::string&) = 0;
    virtual void visit(const Field&, Vec3d&) = 0;
    virtual void visit(const Field&, std::vector<double>&) = 0;
    virtual void visit(const Field&, std::vector<long>&) = 0;
    virtual void visit(const Field&, std::vector<Vec3d>&) = 0;
    virtual void visit(const Field&, std::vector<std::string>&) = 0;
    /// `value` is the index of the chosen name.
    virtual void visit_choice(const Field&, int& value, std::span<const std::string_view> names) = 0;
    /// Enters a sub-table. Returns true where its members are to be visited (a reader returns false where the table is
    /// absent); leave() closes it.
    virtual bool enter(const Field&) = 0;
    virtual void leave() = 0;

    /// An enum whose enumerators 0, 1, ... are spelled `names` in a scene.
    template <class E> void choice(const Field& field, E& value, std::span<const std::string_view> names) {
        int index = static_cast<int>(value);
        visit_choice(field, index, names);
        value = static_cast<E>(index);
    }
    /// A vector that may be absent; visitors see NaN then.
    void visit_optional(const Field& field, std::optional<Vec3d>& vector) {
        Vec3d value = vector.value_or(Vec3d{NAN, NAN, NAN});
        visit(field, value);
        vector = std::isnan(value.x) ? std::nullopt : std::optional(value);
    }
    /// A nested spec struct.
    template <class S> void table(const Field& field, S& spec) {
        if (!enter(field)) return;
        spec.fields(*this);
        leave();
    }
};

} // namespace skein
