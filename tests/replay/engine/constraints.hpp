// Constraints of reference files: values are set after every drift, rates after every kick, in the order of the file.
// They are passes of their own and not part of the kick because dampers act on what they leave. W = 1.
#pragma once

#include "entry.hpp"

#include "skein/tiles/tile.hpp"

#include <memory>
#include <span>

namespace skein::replay {

class Constraint {
public:
    virtual ~Constraint() = default;
    virtual void values(Slot<1>* slot, double time) const = 0;
    virtual void rates(Slot<1>* slot, double time) const = 0;
};

/// `start`: the system's state at the start; how many nodes and elements the file's lists have of it (a closed rod's
/// last slot is no node of its own). Throws NotBuilt.
std::shared_ptr<const Constraint> make_constraint(const Entry& entry, std::span<const Slot<1>> start, std::size_t nodes,
                                                  std::size_t elements);

class ValuesPass final : public TilePass<1> {
public:
    explicit ValuesPass(std::shared_ptr<const Constraint> constraint) : constraint_(std::move(constraint)) {}
    void run(const RodTile<1>& rod, SlotLoad<1>*, const Step& step) const override {
        constraint_->values(rod.slot, step.time);
    }

private:
    std::shared_ptr<const Constraint> constraint_;
};

class RatesPass final : public TilePass<1> {
public:
    explicit RatesPass(std::shared_ptr<const Constraint> constraint) : constraint_(std::move(constraint)) {}
    void run(const RodTile<1>& rod, SlotLoad<1>*, const Step& step) const override {
        constraint_->rates(rod.slot, step.time);
    }

private:
    std::shared_ptr<const Constraint> constraint_;
};

} // namespace skein::replay
