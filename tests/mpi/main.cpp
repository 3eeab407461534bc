// Runs the cases on every rank. Root prints; the run fails where any rank has failed.
#include "parallel/communicator.hpp"

#include <gtest/gtest.h>

#include <iostream>

namespace {

/// Failures of ranks that otherwise do not print.
class FailurePrinter : public testing::EmptyTestEventListener {
    void OnTestPartResult(const testing::TestPartResult& result) override {
        if (!result.failed()) return;
        std::cerr << "rank " << skein::Communicator::world().rank() << ": "
                  << (result.file_name() ? result.file_name() : "?") << ":" << result.line_number() << ": "
                  << result.message() << std::endl;
    }
};

} // namespace

int main(int argc, char** argv) {
    const skein::MpiSession session(argc, argv);
    testing::InitGoogleTest(&argc, argv);
    const auto comm = skein::Communicator::world();
    if (!comm.root()) {
        auto& listeners = testing::UnitTest::GetInstance()->listeners();
        delete listeners.Release(listeners.default_result_printer());
        listeners.Append(new FailurePrinter);
    }
    const std::int64_t result = RUN_ALL_TESTS();
    return static_cast<int>(comm.max(result));
}
