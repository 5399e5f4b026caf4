/** @file tfra_driver.h
 *  Driver of a TFRA core with registers on a bus.
 *
 *  C99, without heap, operating system or floating-point operations; one copy serves any number of cores of any
 *  designs.  `tfra.h` states the registers, `NAME_config.h` the design, `tfra_units.h` converts words to units.
 *  Every function returns at the first error.  Every wait ends after tfra_bus_t::polls reads.
 *  Functions for the same core must not run at the same time.
 */
#ifndef TFRA_DRIVER_H
#define TFRA_DRIVER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "tfra.h"
#include "tfra_constants.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What a function came to. */
typedef enum {
    TFRA_OK = 0,
    TFRA_ERROR_BUS = 1,                  /**< A callback said that an access failed. */
    TFRA_ERROR_ARGUMENT = 2,             /**< An argument is outside its limits; nothing was written. */
    TFRA_ERROR_NO_CORE = 3,              /**< ID is another: no TFRA core is at this address. */
    TFRA_ERROR_MAP_VERSION = 4,          /**< The core has another version of the register map than `tfra.h`. */
    TFRA_ERROR_OTHER_DESIGN = 5,         /**< The core was generated from another configuration. */
    TFRA_ERROR_TIMEOUT = 6,              /**< What the function waited for did not come. */
    TFRA_ERROR_RUNNING = 7,              /**< Settings, tables and coefficients are written to a stopped core. */
    TFRA_ERROR_NOT_LOADED = 8,           /**< The core has no coefficients yet. */
    TFRA_ERROR_LOAD_CHECKSUM = 9,        /**< Coefficients arrived with another checksum. */
    TFRA_ERROR_CALIBRATION_CHECKSUM = 10, /**< Words of a table arrived with another checksum. */
    TFRA_ERROR_FRAME_LENGTH = 11,        /**< An output frame has another number of beats. */
    TFRA_ERROR_FRAME_FORMAT = 12,        /**< An output frame has another format, or words that are too long. */
    TFRA_ERROR_FRAME_ABORTED = 13        /**< A soft reset ended the output frame. */
} tfra_error_t;

/** Reads the 32-bit register at a byte address from the core's base; returns 0, or another number if that failed. */
typedef int (*tfra_read32_t)(void *user, uint32_t address, uint32_t *word);
/** Writes a 32-bit register; returns as ::tfra_read32_t. */
typedef int (*tfra_write32_t)(void *user, uint32_t address, uint32_t word);

/** The way to the registers. */
typedef struct {
    tfra_read32_t read32;
    tfra_write32_t write32;
    void *user;     /**< Passed to both. */
    uint32_t polls; /**< Most reads of a status that a function waits for. */
} tfra_bus_t;

/** A field of the result; `count` is 0 for one that the design does not have. */
typedef struct {
    uint32_t start; /**< Its first word. */
    uint32_t count;
    uint32_t bits;
    bool is_signed;
    double lsb;     /**< Value of one LSB, in its unit; forces times 2^-exponent. */
} tfra_field_t;

/** A design; `NAME_config.h` defines `NAME_config`. */
typedef struct {
    const char *name;
    uint32_t hash_high, hash_low; /**< Hash of the configuration, as in CONFIG_HASH_HIGH and CONFIG_HASH_LOW. */
    uint32_t rows, columns;       /**< Of the array. */
    uint32_t load_words;          /**< Coefficients to load; 0: none. */
    uint32_t repair_places;       /**< Words in the table of repairs. */
    uint32_t words;               /**< Words of a result with the forces at the taxels, if there are any. */
    uint32_t record_words;        /**< Words before the result of each contact on a skin; 0: the core is no skin's. */
    double x_lsb, y_lsb;          /**< Of the places of contacts, in m. */
    tfra_field_t frame, exponent, sweep_index, phi, mu, mu_x, mu_y, resultant, uncertainty, forces, status;
} tfra_config_t;

/** A core; tfra_open() fills it. */
typedef struct {
    tfra_bus_t bus;
    const tfra_config_t *config;
} tfra_device_t;

/** Checks that the core of `config` is on the bus: ID, version of the map, hash.  Changes nothing in the core. */
tfra_error_t tfra_open(tfra_device_t *device, const tfra_bus_t *bus, const tfra_config_t *config);

/** Starts to take frames; TFRA_ERROR_NOT_LOADED before the coefficients are loaded. */
tfra_error_t tfra_start(tfra_device_t *device);
/** Stops, and waits until the last frame is wholly in and no setting or table changes it; take results meanwhile.
 *  TFRA_ERROR_TIMEOUT if its rest does not come: tfra_soft_reset() drops it. */
tfra_error_t tfra_stop(tfra_device_t *device);
/** Waits until no frame is in the core and all results were taken. */
tfra_error_t tfra_wait_idle(tfra_device_t *device);
/** Resets and stops the core; coefficients have to be loaded again, settings and tables stay. */
tfra_error_t tfra_soft_reset(tfra_device_t *device);

/** Options of tfra_set_options(). */
enum {
    TFRA_OPTION_TAXEL_FORCES = TFRA__CONTROL__TAXEL_FORCES_bm,    /**< Frames with the forces at the taxels. */
    TFRA_OPTION_DROP_LATE = TFRA__CONTROL__DROP_LATE_bm,          /**< Late frames are dropped; else they wait. */
    TFRA_OPTION_CHECK_SEQUENCE = TFRA__CONTROL__CHECK_SEQUENCE_bm, /**< The frames' numbers grow by 1. */
    TFRA_OPTION_CUT_THROUGH = TFRA__CONTROL__CUT_THROUGH_bm       /**< Taxels go on before their frame ends. */
};
/** Switches on the given options (or-ed), and the others off. */
tfra_error_t tfra_set_options(tfra_device_t *device, uint32_t options);

/** Progress of the load. */
typedef struct {
    uint32_t count; /**< Coefficients taken since the reset. */
    uint32_t crc;   /**< Their checksum. */
    bool match;     /**< It equals the expected one. */
    bool loaded;    /**< All coefficients are there. */
} tfra_load_t;

/** CRC-32 (zlib, Ethernet) of `word`, lowest byte first, after that of the words before; of none it is 0. */
uint32_t tfra_crc32(uint32_t crc, uint32_t word);
/** Resets the stopped core and loads all `count` coefficients: `NAME_coefficients.h`, or `coefficients/load.hex`. */
tfra_error_t tfra_load(tfra_device_t *device, const int32_t *words, uint32_t count);
tfra_error_t tfra_get_load(tfra_device_t *device, tfra_load_t *load);

/** Settings of the front end; see the registers FRONT_END, THRESHOLDS and STUCK. */
typedef struct {
    uint32_t word_bits;    /**< Bits of a converter's word, 8 to 16. */
    bool is_unsigned;      /**< Words are unsigned; else two's complement. */
    bool invert;           /**< Words less their offsets change their sign. */
    uint32_t log2_average; /**< A code is the mean of 2^log2_average frames; 0 to 6. */
    uint32_t dead_band;    /**< Smaller codes become 0; 16 bits. */
    uint32_t contact;      /**< Frames with smaller codes only become 0; 16 bits. */
    uint32_t stuck_frames; /**< Equal words until a taxel is stuck, up to 255; 0: never. */
} tfra_front_end_t;
tfra_error_t tfra_set_front_end(tfra_device_t *device, const tfra_front_end_t *settings);
tfra_error_t tfra_get_front_end(tfra_device_t *device, tfra_front_end_t *settings);

#ifdef TFRA__CONTACTS__MOST_bp
/** How contacts on a skin are told apart; see the register CONTACTS.  It may change at any time. */
typedef struct {
    uint32_t most;      /**< Contacts of a frame, the highest first. */
    uint32_t threshold; /**< Height of the lowest peak over the highest one's, in 1/TFRA_UNITY_THRESHOLD. */
    uint32_t gap;       /**< Taxels about a contact that belong to no other one. */
} tfra_contact_settings_t;
tfra_error_t tfra_set_contacts(tfra_device_t *device, const tfra_contact_settings_t *settings);
tfra_error_t tfra_get_contacts(tfra_device_t *device, tfra_contact_settings_t *settings);
#endif

/** Writes offsets of `count` taxels from `first` on: signed, 18 bits, in 1/2^17 of the range. */
tfra_error_t tfra_set_offsets(tfra_device_t *device, uint32_t first, const int32_t *offsets, uint32_t count);
/** Writes gains: unsigned, 17 bits; TFRA_UNITY_GAIN is 1, and 0 makes a taxel dead. */
tfra_error_t tfra_set_gains(tfra_device_t *device, uint32_t first, const uint32_t *gains, uint32_t count);
tfra_error_t tfra_get_offsets(tfra_device_t *device, uint32_t first, int32_t *offsets, uint32_t count);
tfra_error_t tfra_get_gains(tfra_device_t *device, uint32_t first, uint32_t *gains, uint32_t count);
/** The word of a repair that chooses `taxel`; the words of its sources follow. */
uint32_t tfra_repair_target(uint32_t taxel);
/** The word of a repair that adds `weight`/65536 times the code of `taxel`; a weight has 18 bits. */
uint32_t tfra_repair_source(uint32_t taxel, int32_t weight);
/** Writes the table of repairs; with a `count` of 0 no taxel is repaired. */
tfra_error_t tfra_set_repairs(tfra_device_t *device, const uint32_t *words, uint32_t count);
/** Reads the words of the table of repairs that are used from the stopped core, `most` at most. */
tfra_error_t tfra_get_repairs(tfra_device_t *device, uint32_t *words, uint32_t most, uint32_t *count);
/** Starts the stopped core; 2^log2_frames frames, 0 to 6, become the offsets. */
tfra_error_t tfra_tare(tfra_device_t *device, uint32_t log2_frames);
/** Waits for the end of tfra_tare(), for `polls` reads at most. */
tfra_error_t tfra_wait_tare(tfra_device_t *device, uint32_t polls);

/** Counters; they wrap. */
typedef struct {
    uint32_t frames_in, frames_out, frames_dropped, frames_saturated, frame_cycles;
} tfra_counters_t;
/** Reads all counters of the same cycle. */
tfra_error_t tfra_get_counters(tfra_device_t *device, tfra_counters_t *counters);
tfra_error_t tfra_clear_counters(tfra_device_t *device);

/** The last taxel with a fault. */
typedef struct {
    uint32_t index; /**< Row by row, from 0. */
    bool saturated, out_of_range, stuck;
} tfra_faulty_taxel_t;
/** Errors since they were cleared, by the masks TFRA__ERRORS__..._bm. */
tfra_error_t tfra_get_errors(tfra_device_t *device, uint32_t *errors);
tfra_error_t tfra_clear_errors(tfra_device_t *device, uint32_t errors);
tfra_error_t tfra_get_faulty_taxel(tfra_device_t *device, tfra_faulty_taxel_t *taxel);
/** Reports the error "simulated", to test the way of errors to the host. */
tfra_error_t tfra_simulate_error(tfra_device_t *device);
/** Reports "stale" after that many clock cycles without a frame; 0: never. */
tfra_error_t tfra_set_stale_timeout(tfra_device_t *device, uint32_t cycles);

/** Which events raise the interrupt: TFRA__INTERRUPT_ENABLE__..._bm. */
tfra_error_t tfra_enable_interrupts(tfra_device_t *device, uint32_t events);
/** Events since they were acknowledged, enabled or not: TFRA__INTERRUPT_STATUS__..._bm. */
tfra_error_t tfra_get_interrupts(tfra_device_t *device, uint32_t *events);
tfra_error_t tfra_acknowledge_interrupts(tfra_device_t *device, uint32_t events);

/** An output frame, as exact integers; words that the design does not have are 0. */
typedef struct {
    uint32_t sequence;     /**< Frames that arrived before it, modulo 65536; a gap means dropped frames. */
    uint32_t user;         /**< Number that came with the frame. */
    uint32_t faults;       /**< At the places of TFRA__ERRORS__..._bm; saturation is that of taxels, of results see status. */
    uint32_t frame;        /**< Number of the result, modulo 65536. */
    uint32_t exponent, sweep_index, phi;
    int32_t mu, mu_x, mu_y;
    int32_t resultant[3];
    int32_t uncertainty;
    uint32_t status;       /**< TFRA_STATUS__... */
    const int32_t *forces; /**< In the beats: f_x of all taxels, then f_y, f_z; NULL for a frame without them. */
} tfra_frame_t;

/** Takes an output frame apart: all its `count` beats. */
tfra_error_t tfra_parse_frame(const tfra_config_t *config, const uint32_t *beats, size_t count, tfra_frame_t *frame);

/** An output frame of a skin, without its contacts. */
typedef struct {
    uint32_t sequence, user, faults, frame; /**< As in ::tfra_frame_t. */
    uint32_t dropped;                       /**< Peaks beyond as many contacts as there may be. */
    size_t contacts;
} tfra_skin_frame_t;

/** A contact on a skin. */
typedef struct {
    uint32_t row, column; /**< Of the centroid of its region, from the first taxel, in 1/TFRA_UNITY_PLACE. */
    uint32_t taxels;      /**< Of its region. */
    uint32_t marks;       /**< TFRA_MARK__... */
    tfra_frame_t window;  /**< What the estimator made of the window about it; header and `frame` are the frame's. */
} tfra_contact_t;

/** Takes an output frame of a skin apart: all its `count` beats; `contacts` has room for TFRA_CONTACTS_MOST. */
tfra_error_t tfra_parse_contacts(const tfra_config_t *config, const uint32_t *beats, size_t count,
                                 tfra_skin_frame_t *frame, tfra_contact_t *contacts);

/** Callbacks for registers in memory; `tfra_bus_t::user` is their base. */
static inline int tfra_memory_read32(void *base, uint32_t address, uint32_t *word)
{
    *word = *(volatile const uint32_t *)((uintptr_t)base + address);
    return 0;
}

static inline int tfra_memory_write32(void *base, uint32_t address, uint32_t word)
{
    *(volatile uint32_t *)((uintptr_t)base + address) = word;
    return 0;
}

#ifdef __cplusplus
}
#endif

#endif
