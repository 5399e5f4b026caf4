/* What Python cannot take from the C driver as a shared library: the design, which is a constant of a header, and one
   with another hash. */
#include "DESIGN_config.h"

const tfra_config_t *design(uint32_t hash_low);

const tfra_config_t *design(uint32_t hash_low)
{
    static tfra_config_t other;
    other = DESIGN_config;
    other.hash_low = hash_low;
    return hash_low == DESIGN_config.hash_low ? &DESIGN_config : &other;
}
