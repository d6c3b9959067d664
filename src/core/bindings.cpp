// Python's view of the core: arrays in, arrays out, the interpreter's lock released. No logic.
#include "bindings.hpp"

NB_MODULE(_core, module) {
    // What is kept of an arm lives until the interpreter ends: that is no leak, and nothing to tell a user.
    nanobind::set_leak_warnings(false);
    rankdrop::bind_chain(module);
    rankdrop::bind_search(module);
    rankdrop::bind_certify(module);
    rankdrop::bind_families(module);
    rankdrop::bind_cover(module);
    rankdrop::bind_aim(module);
}
