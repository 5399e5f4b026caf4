/* Reads output frames of a skin from the standard input and says what the driver makes of them: a line for each.
   A frame is its number of beats and the beats, in hexadecimal. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "DESIGN_config.h"
#include "tfra_units.h"

static void show(const tfra_contact_t *contact)
{
    const tfra_config_t *const config = &DESIGN_config;
    const tfra_frame_t *const window = &contact->window;
    printf(" %" PRIu32 " %" PRIu32 " %" PRIu32 " %" PRIu32, contact->row, contact->column, contact->taxels,
           contact->marks);
    printf(" %" PRIu32 " %" PRIu32 " %" PRIu32 " %" PRIu32, window->frame, window->user, window->exponent,
           window->status);
    printf(" %a %a %a %a", tfra_x(config, contact), tfra_y(config, contact), tfra_phi(config, window),
           tfra_mu(config, window));
    for (uint32_t axis = 0; axis < 3; axis++)
        printf(" %a", tfra_resultant(config, window, axis));
    for (uint32_t axis = 0; window->forces && axis < 3; axis++)
        for (uint32_t taxel = 0; taxel < config->forces.count / 3u; taxel++)
            printf(" %a", tfra_force(config, window, axis, taxel));
}

int main(void)
{
    static tfra_contact_t contacts[TFRA_CONTACTS_MOST];
    size_t count;
    while (scanf("%zx", &count) == 1) {
        uint32_t *const beats = malloc((count ? count : 1) * sizeof *beats); /* of its size, so a sanitizer sees more */
        tfra_skin_frame_t frame;
        if (!beats)
            return 1;
        for (size_t beat = 0; beat < count; beat++)
            if (scanf("%" SCNx32, &beats[beat]) != 1)
                return 1;
        const tfra_error_t error = tfra_parse_contacts(&DESIGN_config, beats, count, &frame, contacts);
        printf("%d", (int)error);
        if (error == TFRA_OK) {
            printf(" %" PRIu32 " %" PRIu32 " %" PRIu32 " %" PRIu32 " %" PRIu32 " %zu", frame.sequence, frame.user,
                   frame.faults, frame.frame, frame.dropped, frame.contacts);
            for (size_t number = 0; number < frame.contacts; number++)
                show(&contacts[number]);
        }
        printf("\n");
        free(beats);
    }
    return 0;
}
