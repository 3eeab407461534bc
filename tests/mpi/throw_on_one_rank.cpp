// Ends badly on rank 1 while the others wait for it: all must end, with rank 1's message.
#include "parallel/communicator.hpp"
#include "skein/core/error.hpp"

#include <cstddef>
#include <limits>
#include <memory>
#include <string>

using namespace skein;

int main(int argc, char** argv) {
    const MpiSession session(argc, argv);
    const auto comm = Communicator::world();
    const std::string way = argv[1];
    if (comm.rank() == 1) {
        if (way == "exception") throw NumericalError("thrown on purpose");
        if (way == "memory") std::make_unique<char[]>(std::numeric_limits<std::ptrdiff_t>::max());
    }
    comm.barrier();
    return 0;
}
