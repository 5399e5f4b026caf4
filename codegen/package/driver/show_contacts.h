/** @file show.h
 *  Prints what the driver makes of an output frame of a skin.
 */
#ifndef SHOW_H
#define SHOW_H

#include <stdio.h>

#include "tfra_units.h"

static inline tfra_error_t show(const tfra_config_t *config, const uint32_t *beats, size_t count)
{
    static tfra_contact_t contacts[TFRA_CONTACTS_MOST];
    tfra_skin_frame_t frame;
    const tfra_error_t error = tfra_parse_contacts(config, beats, count, &frame, contacts);
    if (error != TFRA_OK)
        return error;
    printf("%u: %u contacts, %u dropped, faults 0x%03x\n", (unsigned)frame.sequence, (unsigned)frame.contacts,
           (unsigned)frame.dropped, (unsigned)frame.faults);
    for (size_t number = 0; number < frame.contacts; number++) {
        const tfra_contact_t *const contact = &contacts[number];
        const tfra_frame_t *const window = &contact->window;
        printf("  at %.4f %.4f m: %.6f %.6f %.6f N, friction %.3f, marks 0x%x\n", tfra_x(config, contact),
               tfra_y(config, contact), tfra_resultant(config, window, 0), tfra_resultant(config, window, 1),
               tfra_resultant(config, window, 2), tfra_mu(config, window), (unsigned)contact->marks);
    }
    return TFRA_OK;
}

#endif
