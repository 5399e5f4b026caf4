/** @file example.c
 *  Calibrates a core, and prints the resultant force of frames.
 *
 *  Build with: cc -std=c99 -Idriver -Iregisters driver/example.c driver/tfra_driver.c driver/tfra_frame.c
 */
#include <stdio.h>

#include "NAME_config.h"
#include "tfra_units.h"

#define MOST_BEATS 16384
#define FRAMES 10

/** Provided by the board: the base of the registers, and the next output frame, for example from a DMA. */
extern void *board_registers(void);
extern size_t board_receive(uint32_t *beats, size_t most);

static int failed(const char *what, tfra_error_t error)
{
    fprintf(stderr, "%s: error %d\n", what, (int)error);
    return 1;
}

int main(void)
{
    static uint32_t beats[MOST_BEATS];
    const tfra_bus_t bus = {tfra_memory_read32, tfra_memory_write32, board_registers(), 1000000};
    const tfra_config_t *const config = &NAME_config;
    tfra_device_t device;
    tfra_frame_t frame;
    tfra_error_t error;

    if ((error = tfra_open(&device, &bus, config)) != TFRA_OK)
        return failed("open", error);
    if ((error = tfra_tare(&device, 3)) != TFRA_OK || (error = tfra_wait_tare(&device, 1000000)) != TFRA_OK)
        return failed("tare", error);
    for (int number = 0; number < FRAMES; number++) {
        const size_t count = board_receive(beats, MOST_BEATS);
        if ((error = tfra_parse_frame(config, beats, count, 0, &frame)) != TFRA_OK)
            return failed("frame", error);
        printf("%u: %.4f %.4f %.4f N, friction %.3f, faults 0x%03x\n", (unsigned)frame.sequence,
               tfra_resultant(config, &frame, 0), tfra_resultant(config, &frame, 1), tfra_resultant(config, &frame, 2),
               tfra_mu(config, &frame), (unsigned)frame.faults);
    }
    return tfra_stop(&device) == TFRA_OK ? 0 : 1;
}
