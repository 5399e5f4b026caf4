/** @file show.h
 *  Prints what the driver makes of an output frame.
 */
#ifndef SHOW_H
#define SHOW_H

#include <stdio.h>

#include "tfra_units.h"

static inline tfra_error_t show(const tfra_config_t *config, const uint32_t *beats, size_t count)
{
    tfra_frame_t frame;
    const tfra_error_t error = tfra_parse_frame(config, beats, count, &frame);
    if (error != TFRA_OK)
        return error;
    printf("%u: %.6f %.6f %.6f N, friction %.3f, faults 0x%03x\n", (unsigned)frame.sequence,
           tfra_resultant(config, &frame, 0), tfra_resultant(config, &frame, 1), tfra_resultant(config, &frame, 2),
           tfra_mu(config, &frame), (unsigned)frame.faults);
    return TFRA_OK;
}

#endif
