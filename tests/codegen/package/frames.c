/* Reads output frames from the standard input and says what the driver makes of them: a line for each.
   A frame is its TUSER, its number of beats and the beats, in hexadecimal. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "DESIGN_config.h"
#include "tfra_units.h"

static void show(const tfra_frame_t *frame)
{
    const tfra_config_t *const config = &DESIGN_config;
    printf("0 %" PRIu32 " %" PRIu32 " %" PRIu32 " %" PRIu32 " %" PRIu32 " %" PRIu32 " %" PRIu32, frame->sequence,
           frame->user, frame->faults, frame->frame, frame->exponent, frame->sweep_index, frame->phi);
    printf(" %" PRId32 " %" PRId32 " %" PRId32 " %" PRId32 " %" PRIu32, frame->mu, frame->mu_x, frame->mu_y,
           frame->uncertainty, frame->status);
    printf(" %a %a %a %a %a", tfra_phi(config, frame), tfra_mu(config, frame), tfra_mu_x(config, frame),
           tfra_mu_y(config, frame), tfra_uncertainty(config, frame));
    for (uint32_t axis = 0; axis < 3; axis++)
        printf(" %a", tfra_resultant(config, frame, axis));
    for (uint32_t axis = 0; frame->forces && axis < 3; axis++)
        for (uint32_t taxel = 0; taxel < config->rows * config->columns; taxel++)
            printf(" %a", tfra_force(config, frame, axis, taxel));
    printf("\n");
}

int main(void)
{
    size_t count;
    while (scanf("%zx", &count) == 1) {
        uint32_t *const beats = malloc((count ? count : 1) * sizeof *beats); /* of its size, so a sanitizer sees more */
        tfra_frame_t frame;
        if (!beats)
            return 1;
        for (size_t beat = 0; beat < count; beat++)
            if (scanf("%" SCNx32, &beats[beat]) != 1)
                return 1;
        const tfra_error_t error = tfra_parse_frame(&DESIGN_config, beats, count, &frame);
        if (error == TFRA_OK)
            show(&frame);
        else
            printf("%d\n", (int)error);
        free(beats);
    }
    return 0;
}
