// Python's view of the core: arrays in, arrays out, the interpreter's lock released. No logic.
#include "bindings.hpp"

NB_MODULE(_core, module) {
    rankdrop::bind_chain(module);
    rankdrop::bind_search(module);
    rankdrop::bind_certify(module);
    rankdrop::bind_families(module);
    rankdrop::bind_cover(module);
    rankdrop::bind_aim(module);
}
