/** @file tfra_driver.c
 *  Registers and tables of a TFRA core; tfra_driver.h describes the functions.
 */
#include "tfra_driver.h"

#define ADDRESS(reg) ((uint32_t)offsetof(tfra_t, reg))
#define MASK(reg, field) ((uint32_t)TFRA__##reg##__##field##_bm)
#define GET(word, reg, field) (((word) & MASK(reg, field)) >> TFRA__##reg##__##field##_bp)
#define PUT(value, reg, field) ((uint32_t)(value) << TFRA__##reg##__##field##_bp)
#define FITS(value, reg, field) ((value) <= (MASK(reg, field) >> TFRA__##reg##__##field##_bp))
#define READ(device, reg, word) read_register(device, ADDRESS(reg), word)
#define WRITE(device, reg, word) write_register(device, ADDRESS(reg), word)
#define CHECK(call)                       \
    do {                                  \
        const tfra_error_t error = (call); \
        if (error != TFRA_OK)             \
            return error;                 \
    } while (0)

#define OPTIONS ((uint32_t)TFRA_OPTION_TAXEL_FORCES | TFRA_OPTION_DROP_LATE | TFRA_OPTION_CHECK_SEQUENCE | TFRA_OPTION_CUT_THROUGH)

static tfra_error_t read_register(tfra_device_t *device, uint32_t address, uint32_t *word)
{
    return device->bus.read32(device->bus.user, address, word) ? TFRA_ERROR_BUS : TFRA_OK;
}

static tfra_error_t write_register(tfra_device_t *device, uint32_t address, uint32_t word)
{
    return device->bus.write32(device->bus.user, address, word) ? TFRA_ERROR_BUS : TFRA_OK;
}

/** Waits until the bits `mask` of a register equal `value`. */
static tfra_error_t wait_for(tfra_device_t *device, uint32_t address, uint32_t mask, uint32_t value, uint32_t polls)
{
    while (polls--) {
        uint32_t word;
        CHECK(read_register(device, address, &word));
        if ((word & mask) == value)
            return TFRA_OK;
    }
    return TFRA_ERROR_TIMEOUT;
}

/** Writes CONTROL with its options as they are, and of `run` and the pulses those in `bits`. */
static tfra_error_t control(tfra_device_t *device, uint32_t bits)
{
    uint32_t word;
    CHECK(READ(device, CONTROL, &word));
    return WRITE(device, CONTROL, (word & OPTIONS) | bits);
}

/** Writes CONTROL with its settings as they are, and the pulse `bit`. */
static tfra_error_t pulse(tfra_device_t *device, uint32_t bit)
{
    uint32_t word;
    CHECK(READ(device, CONTROL, &word));
    return WRITE(device, CONTROL, word | bit);
}

static tfra_error_t require_stopped(tfra_device_t *device)
{
    uint32_t status, word;
    CHECK(READ(device, CONTROL, &word));
    CHECK(READ(device, STATUS, &status));
    return (word & MASK(CONTROL, RUN)) || (status & MASK(STATUS, RUNNING)) ? TFRA_ERROR_RUNNING : TFRA_OK;
}

tfra_error_t tfra_open(tfra_device_t *device, const tfra_bus_t *bus, const tfra_config_t *config)
{
    uint32_t word, low, high;
    device->bus = *bus;
    device->config = config;
    CHECK(READ(device, ID, &word));
    if (word != TFRA__ID__TEXT_reset)
        return TFRA_ERROR_NO_CORE;
    CHECK(READ(device, VERSION, &word));
    if (GET(word, VERSION, MAP) != TFRA__VERSION__MAP_reset)
        return TFRA_ERROR_MAP_VERSION;
    CHECK(READ(device, CONFIG_HASH_LOW, &low));
    CHECK(READ(device, CONFIG_HASH_HIGH, &high));
    return low == config->hash_low && high == config->hash_high ? TFRA_OK : TFRA_ERROR_OTHER_DESIGN;
}

tfra_error_t tfra_start(tfra_device_t *device)
{
    uint32_t status;
    CHECK(READ(device, STATUS, &status));
    if (!(status & MASK(STATUS, LOADED)))
        return TFRA_ERROR_NOT_LOADED;
    return control(device, MASK(CONTROL, RUN));
}

tfra_error_t tfra_stop(tfra_device_t *device)
{
    CHECK(control(device, 0));
    return wait_for(device, ADDRESS(STATUS), MASK(STATUS, RUNNING), 0, device->bus.polls);
}

tfra_error_t tfra_wait_idle(tfra_device_t *device)
{
    return wait_for(device, ADDRESS(STATUS), MASK(STATUS, BUSY), 0, device->bus.polls);
}

tfra_error_t tfra_soft_reset(tfra_device_t *device)
{
    return control(device, MASK(CONTROL, SOFT_RESET));
}

tfra_error_t tfra_set_options(tfra_device_t *device, uint32_t options)
{
    uint32_t word;
    if (options & ~OPTIONS)
        return TFRA_ERROR_ARGUMENT;
    CHECK(READ(device, CONTROL, &word));
    return WRITE(device, CONTROL, (word & MASK(CONTROL, RUN)) | options);
}

uint32_t tfra_crc32(uint32_t crc, uint32_t word)
{
    uint32_t bits = ~crc ^ word;
    for (int bit = 0; bit < 32; bit++)
        bits = (bits >> 1) ^ (bits & 1u ? 0xEDB88320u : 0u);
    return ~bits;
}

tfra_error_t tfra_load(tfra_device_t *device, const int32_t *words, uint32_t count)
{
    uint32_t crc = 0, status;
    if (count == 0 || count != device->config->load_words)
        return TFRA_ERROR_ARGUMENT;
    CHECK(require_stopped(device));
    CHECK(tfra_soft_reset(device));
    for (uint32_t place = 0; place < count; place++)
        crc = tfra_crc32(crc, (uint32_t)words[place]);
    CHECK(WRITE(device, LOAD_CHECKSUM, crc));
    for (uint32_t place = 0; place < count; place++) {
        const uint32_t ready = MASK(LOAD_STATUS, READY);
        CHECK(wait_for(device, ADDRESS(LOAD_STATUS), ready, ready, device->bus.polls));
        CHECK(WRITE(device, LOAD_DATA, (uint32_t)words[place]));
    }
    CHECK(wait_for(device, ADDRESS(STATUS), MASK(STATUS, LOADED), MASK(STATUS, LOADED), device->bus.polls));
    CHECK(READ(device, LOAD_STATUS, &status));
    return status & MASK(LOAD_STATUS, MATCH) ? TFRA_OK : TFRA_ERROR_LOAD_CHECKSUM;
}

tfra_error_t tfra_get_load(tfra_device_t *device, tfra_load_t *load)
{
    uint32_t match, status;
    CHECK(READ(device, LOAD_COUNT, &load->count));
    CHECK(READ(device, LOAD_CRC, &load->crc));
    CHECK(READ(device, LOAD_STATUS, &match));
    CHECK(READ(device, STATUS, &status));
    load->match = GET(match, LOAD_STATUS, MATCH) != 0;
    load->loaded = GET(status, STATUS, LOADED) != 0;
    return TFRA_OK;
}

tfra_error_t tfra_set_front_end(tfra_device_t *device, const tfra_front_end_t *settings)
{
    if (settings->word_bits < TFRA_WORD_BITS_LEAST || settings->word_bits > TFRA_WORD_BITS_MOST ||
        settings->log2_average > TFRA_LOG2_FRAMES_MOST || !FITS(settings->dead_band, THRESHOLDS, DEAD_BAND) ||
        !FITS(settings->contact, THRESHOLDS, CONTACT) || !FITS(settings->stuck_frames, STUCK, FRAMES))
        return TFRA_ERROR_ARGUMENT;
    CHECK(require_stopped(device));
    CHECK(WRITE(device, FRONT_END,
                PUT(settings->word_bits, FRONT_END, WORD_BITS) | PUT(settings->is_unsigned, FRONT_END, IS_UNSIGNED) |
                    PUT(settings->invert, FRONT_END, INVERT) | PUT(settings->log2_average, FRONT_END, LOG2_AVERAGE)));
    CHECK(WRITE(device, THRESHOLDS,
                PUT(settings->dead_band, THRESHOLDS, DEAD_BAND) | PUT(settings->contact, THRESHOLDS, CONTACT)));
    return WRITE(device, STUCK, PUT(settings->stuck_frames, STUCK, FRAMES));
}

tfra_error_t tfra_get_front_end(tfra_device_t *device, tfra_front_end_t *settings)
{
    uint32_t front_end, thresholds, stuck;
    CHECK(READ(device, FRONT_END, &front_end));
    CHECK(READ(device, THRESHOLDS, &thresholds));
    CHECK(READ(device, STUCK, &stuck));
    settings->word_bits = GET(front_end, FRONT_END, WORD_BITS);
    settings->is_unsigned = GET(front_end, FRONT_END, IS_UNSIGNED) != 0;
    settings->invert = GET(front_end, FRONT_END, INVERT) != 0;
    settings->log2_average = GET(front_end, FRONT_END, LOG2_AVERAGE);
    settings->dead_band = GET(thresholds, THRESHOLDS, DEAD_BAND);
    settings->contact = GET(thresholds, THRESHOLDS, CONTACT);
    settings->stuck_frames = GET(stuck, STUCK, FRAMES);
    return TFRA_OK;
}

#ifdef TFRA__CONTACTS__MOST_bp
tfra_error_t tfra_set_contacts(tfra_device_t *device, const tfra_contact_settings_t *settings)
{
    if (settings->most < 1u || settings->most > TFRA_CONTACTS_MOST || settings->threshold < 1u ||
        settings->threshold > TFRA_UNITY_THRESHOLD || settings->gap > TFRA_GAP_MOST)
        return TFRA_ERROR_ARGUMENT;
    return WRITE(device, CONTACTS,
                 PUT(settings->most, CONTACTS, MOST) | PUT(settings->threshold, CONTACTS, THRESHOLD) |
                     PUT(settings->gap, CONTACTS, GAP));
}

tfra_error_t tfra_get_contacts(tfra_device_t *device, tfra_contact_settings_t *settings)
{
    uint32_t word;
    CHECK(READ(device, CONTACTS, &word));
    settings->most = GET(word, CONTACTS, MOST);
    settings->threshold = GET(word, CONTACTS, THRESHOLD);
    settings->gap = GET(word, CONTACTS, GAP);
    return TFRA_OK;
}
#endif

static uint32_t place_of(uint32_t table, uint32_t index)
{
    return PUT(index, CALIBRATION_PLACE, INDEX) | PUT(table, CALIBRATION_PLACE, KIND);
}

/** Whether `count` places from `first` on are taxels. */
static bool are_taxels(const tfra_device_t *device, uint32_t first, uint32_t count)
{
    const uint32_t taxels = device->config->rows * device->config->columns;
    return first <= taxels && count <= taxels - first;
}

static bool is_signed_word(int32_t word, uint32_t bits)
{
    const int32_t limit = (int32_t)(1u << (bits - 1u));
    return word >= -limit && word < limit;
}

/** Writes words of a table of the stopped core, and compares their checksum. */
static tfra_error_t write_table(tfra_device_t *device, uint32_t table, uint32_t first, const uint32_t *words,
                                uint32_t count)
{
    uint32_t crc = 0, found;
    CHECK(require_stopped(device));
    CHECK(WRITE(device, CALIBRATION_PLACE, place_of(table, first)));
    for (uint32_t place = 0; place < count; place++) {
        crc = tfra_crc32(crc, words[place]);
        CHECK(WRITE(device, CALIBRATION_DATA, words[place]));
    }
    CHECK(READ(device, CALIBRATION_CRC, &found));
    return found == crc ? TFRA_OK : TFRA_ERROR_CALIBRATION_CHECKSUM;
}

static tfra_error_t read_table(tfra_device_t *device, uint32_t table, uint32_t first, uint32_t *words, uint32_t count)
{
    for (uint32_t place = 0; place < count; place++) {
        CHECK(WRITE(device, CALIBRATION_PLACE, place_of(table, first + place)));
        CHECK(READ(device, CALIBRATION_VALUE, &words[place]));
    }
    return TFRA_OK;
}

tfra_error_t tfra_set_offsets(tfra_device_t *device, uint32_t first, const int32_t *offsets, uint32_t count)
{
    if (!are_taxels(device, first, count))
        return TFRA_ERROR_ARGUMENT;
    for (uint32_t place = 0; place < count; place++)
        if (!is_signed_word(offsets[place], TFRA_OFFSET_BITS))
            return TFRA_ERROR_ARGUMENT;
    return write_table(device, TFRA_TABLE_OFFSETS, first, (const uint32_t *)offsets, count);
}

tfra_error_t tfra_set_gains(tfra_device_t *device, uint32_t first, const uint32_t *gains, uint32_t count)
{
    if (!are_taxels(device, first, count))
        return TFRA_ERROR_ARGUMENT;
    for (uint32_t place = 0; place < count; place++)
        if (gains[place] >> TFRA_GAIN_BITS)
            return TFRA_ERROR_ARGUMENT;
    return write_table(device, TFRA_TABLE_GAINS, first, gains, count);
}

tfra_error_t tfra_get_offsets(tfra_device_t *device, uint32_t first, int32_t *offsets, uint32_t count)
{
    const uint32_t sign = 1u << (TFRA_OFFSET_BITS - 1u);
    if (!are_taxels(device, first, count))
        return TFRA_ERROR_ARGUMENT;
    CHECK(read_table(device, TFRA_TABLE_OFFSETS, first, (uint32_t *)offsets, count));
    for (uint32_t place = 0; place < count; place++) {
        const uint32_t word = (uint32_t)offsets[place] & (2u * sign - 1u);
        offsets[place] = (int32_t)(word & (sign - 1u)) - (int32_t)(word & sign);
    }
    return TFRA_OK;
}

tfra_error_t tfra_get_gains(tfra_device_t *device, uint32_t first, uint32_t *gains, uint32_t count)
{
    return are_taxels(device, first, count) ? read_table(device, TFRA_TABLE_GAINS, first, gains, count)
                                            : TFRA_ERROR_ARGUMENT;
}

uint32_t tfra_repair_target(uint32_t taxel)
{
    return 1u << TFRA_REPAIR_TARGET_BIT | taxel << TFRA_REPAIR_WEIGHT_BITS;
}

uint32_t tfra_repair_source(uint32_t taxel, int32_t weight)
{
    return taxel << TFRA_REPAIR_WEIGHT_BITS | ((uint32_t)weight & ((1u << TFRA_REPAIR_WEIGHT_BITS) - 1u));
}

tfra_error_t tfra_set_repairs(tfra_device_t *device, const uint32_t *words, uint32_t count)
{
    if (count > device->config->repair_places)
        return TFRA_ERROR_ARGUMENT;
    for (uint32_t place = 0; place < count; place++) {
        const uint32_t taxel = (words[place] & ~(1u << TFRA_REPAIR_TARGET_BIT)) >> TFRA_REPAIR_WEIGHT_BITS;
        if (!are_taxels(device, taxel, 1) || (place == 0 && !(words[place] >> TFRA_REPAIR_TARGET_BIT)))
            return TFRA_ERROR_ARGUMENT;
    }
    CHECK(require_stopped(device));
    CHECK(WRITE(device, REPAIRS, 0));
    CHECK(write_table(device, TFRA_TABLE_REPAIRS, 0, words, count));
    return WRITE(device, REPAIRS, PUT(count, REPAIRS, WORDS));
}

tfra_error_t tfra_get_repairs(tfra_device_t *device, uint32_t *words, uint32_t most, uint32_t *count)
{
    CHECK(require_stopped(device));
    CHECK(READ(device, REPAIRS, count));
    return *count <= most ? read_table(device, TFRA_TABLE_REPAIRS, 0, words, *count) : TFRA_ERROR_ARGUMENT;
}

tfra_error_t tfra_tare(tfra_device_t *device, uint32_t log2_frames)
{
    if (log2_frames > TFRA_LOG2_FRAMES_MOST)
        return TFRA_ERROR_ARGUMENT;
    CHECK(require_stopped(device));
    CHECK(WRITE(device, TARE, PUT(log2_frames, TARE, LOG2_FRAMES)));
    CHECK(pulse(device, MASK(CONTROL, TARE)));
    return tfra_start(device);
}

tfra_error_t tfra_wait_tare(tfra_device_t *device, uint32_t polls)
{
    return wait_for(device, ADDRESS(STATUS), MASK(STATUS, TARING), 0, polls);
}

tfra_error_t tfra_get_counters(tfra_device_t *device, tfra_counters_t *counters)
{
    uint32_t word;
    CHECK(READ(device, CONTROL, &word));
    CHECK(WRITE(device, CONTROL, word | MASK(CONTROL, HOLD_COUNTERS)));
    CHECK(READ(device, FRAMES_IN, &counters->frames_in));
    CHECK(READ(device, FRAMES_OUT, &counters->frames_out));
    CHECK(READ(device, FRAMES_DROPPED, &counters->frames_dropped));
    CHECK(READ(device, FRAMES_SATURATED, &counters->frames_saturated));
    CHECK(READ(device, FRAME_CYCLES, &counters->frame_cycles));
    return WRITE(device, CONTROL, word);
}

tfra_error_t tfra_clear_counters(tfra_device_t *device)
{
    return pulse(device, MASK(CONTROL, CLEAR_COUNTERS));
}

tfra_error_t tfra_get_errors(tfra_device_t *device, uint32_t *errors)
{
    return READ(device, ERRORS, errors);
}

tfra_error_t tfra_clear_errors(tfra_device_t *device, uint32_t errors)
{
    return WRITE(device, ERRORS, errors);
}

tfra_error_t tfra_get_faulty_taxel(tfra_device_t *device, tfra_faulty_taxel_t *taxel)
{
    uint32_t word;
    CHECK(READ(device, FAULTY_TAXEL, &word));
    taxel->index = GET(word, FAULTY_TAXEL, INDEX);
    taxel->saturated = GET(word, FAULTY_TAXEL, SATURATED) != 0;
    taxel->out_of_range = GET(word, FAULTY_TAXEL, OUT_OF_RANGE) != 0;
    taxel->stuck = GET(word, FAULTY_TAXEL, STUCK) != 0;
    return TFRA_OK;
}

tfra_error_t tfra_simulate_error(tfra_device_t *device)
{
    return pulse(device, MASK(CONTROL, SIMULATE_ERROR));
}

tfra_error_t tfra_set_stale_timeout(tfra_device_t *device, uint32_t cycles)
{
    return WRITE(device, FRAME_TIMEOUT, cycles);
}

tfra_error_t tfra_enable_interrupts(tfra_device_t *device, uint32_t events)
{
    return WRITE(device, INTERRUPT_ENABLE, events);
}

tfra_error_t tfra_get_interrupts(tfra_device_t *device, uint32_t *events)
{
    return READ(device, INTERRUPT_STATUS, events);
}

tfra_error_t tfra_acknowledge_interrupts(tfra_device_t *device, uint32_t events)
{
    return WRITE(device, INTERRUPT_STATUS, events);
}
