// A visitor that passes over all fields. Visitors that search for some fields override these functions.
#pragma once

#include "skein/core/fields.hpp"

namespace skein {

class FieldLooker : public FieldVisitor {
public:
    void visit(const Field&, double&) override {}
    void visit(const Field&, long&) override {}
    void visit(const Field&, bool&) override {}
    void visit(const Field&, std::string&) override {}
    void visit(const Field&, Vec3d&) override {}
    void visit(const Field&, std::vector<double>&) override {}
    void visit(const Field&, std::vector<long>&) override {}
    void visit(const Field&, std::vector<Vec3d>&) override {}
    void visit(const Field&, std::vector<std::string>&) override {}
    void visit_choice(const Field&, int&, std::span<const std::string_view>) override {}
    bool enter(const Field&) override { return true; }
    void leave() override {}
};

} // namespace skein
