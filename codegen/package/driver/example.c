/** @file example.c
 *  Calibrates a core, and shows what it makes of ten frames.
 *
 *  Build it with your board's functions, in the package's folder:
 *  cc -std=c99 -Idriver -Iregisters driver/example.c driver/tfra_driver.c driver/tfra_frame.c board.c
 */
#include <stdio.h>
#include <stdlib.h>

#include "NAME_config.h"
#include "NAME_coefficients.h"
#include "show.h"

#define POLLS 1000000

/** The base of the registers. */
extern void *board_registers(void);
/** Waits for the next output frame, from a DMA for example, and returns its number of beats. */
extern size_t board_receive(uint32_t *beats, size_t most);

static void check(const char *what, tfra_error_t error)
{
    if (error != TFRA_OK) {
        fprintf(stderr, "%s: error %d\n", what, (int)error);
        exit(1);
    }
}

/** Words of offset binary are unsigned; after a reset they are two's complement. */
static tfra_error_t set_words(tfra_device_t *device, bool is_unsigned)
{
    tfra_front_end_t settings;
    const tfra_error_t error = tfra_get_front_end(device, &settings);
    settings.is_unsigned = is_unsigned;
    return error != TFRA_OK ? error : tfra_set_front_end(device, &settings);
}

int main(void)
{
    static uint32_t beats[NAME_MOST_BEATS];
    const tfra_bus_t bus = {tfra_memory_read32, tfra_memory_write32, board_registers(), POLLS};
    const tfra_config_t *const config = &NAME_config;
    tfra_device_t device;

    check("open", tfra_open(&device, &bus, config));
    check("load", tfra_load(&device, NAME_coefficients, config->load_words));
    check("front end", set_words(&device, false)); /* true: offset binary */
    check("tare", tfra_tare(&device, 3)); /* nothing may touch the sensor now */
    check("tare", tfra_wait_tare(&device, POLLS));
    for (int number = 0; number < 10; number++) {
        const size_t count = board_receive(beats, NAME_MOST_BEATS);
        check("frame", show(config, beats, count));
    }
    check("stop", tfra_stop(&device));
    return 0;
}
