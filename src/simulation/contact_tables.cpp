// Tables of all contacts, a file per step.
#include "io/files.hpp"
#include "physics/contact/contact_interaction.hpp"
#include "simulation/output.hpp"

#include <fmt/format.h>

namespace skein {

namespace {

class ContactTableOutput final : public PeriodicOutput {
public:
    explicit ContactTableOutput(const OutputParts& parts)
        : PeriodicOutput(parts.plan().cadence.of("contacts")), world_(parts.world), directory_(parts.options.out) {}

    bool needs_state_alone() const override { return false; }
    void write(const Moment& now) override {
        if (now.step > 0)
            write_file(world_.comm, directory_ + "/" + files_of(now.step).front(),
                       contacts_of(world_.interactions())->table());
    }

private:
    std::vector<std::string> files_of(std::int64_t step) const override {
        return {fmt::format("contacts_{:012d}.csv", step)};
    }

    const World& world_;
    std::string directory_;
};

} // namespace

std::unique_ptr<Output> make_contact_tables(const OutputParts& parts) {
    return parts.plan().cadence.of("contacts") > 0 ? std::make_unique<ContactTableOutput>(parts) : nullptr;
}

} // namespace skein
