/** @file tfra_frame.c
 *  Takes output frames of a TFRA core apart; tfra_driver.h describes the function.  No access to the core.
 */
#include "tfra_driver.h"

#define HEADER(beats, field) \
    (((beats)[TFRA_HEADER__##field##_beat] & TFRA_HEADER__##field##_bm) >> TFRA_HEADER__##field##_bp)

/** Result words of a frame, of which `skipped` from the first force on were left out. */
typedef struct {
    const uint32_t *words;
    const tfra_field_t *forces;
    uint32_t skipped;
} result_t;

static const uint32_t *words_of(const result_t *result, const tfra_field_t *field)
{
    return result->words + field->start - (field->start > result->forces->start ? result->skipped : 0u);
}

static uint32_t word_of(const result_t *result, const tfra_field_t *field)
{
    return field->count ? *words_of(result, field) : 0u;
}

static int32_t signed_of(const result_t *result, const tfra_field_t *field)
{
    return field->count ? *(const int32_t *)words_of(result, field) : 0;
}

/** Whether the bits of every word beyond those of the field extend it. */
static bool is_extended(const result_t *result, const tfra_field_t *field)
{
    const uint32_t count = field == result->forces ? field->count - result->skipped : field->count;
    const uint32_t bits = field->bits - (field->is_signed ? 1u : 0u);
    for (uint32_t place = 0; place < count; place++) {
        const uint32_t word = words_of(result, field)[place];
        const uint32_t above = field->is_signed && word >> 31 ? ~word : word;
        if (bits < 32u && above >> bits)
            return false;
    }
    return true;
}

tfra_error_t tfra_parse_frame(const tfra_config_t *config, const uint32_t *beats, size_t count, tfra_frame_t *frame)
{
    const size_t whole = (size_t)TFRA_HEADER_BEATS + config->words;
    const tfra_field_t *const fields[] = {
        &config->frame, &config->exponent, &config->sweep_index, &config->phi,    &config->mu,    &config->mu_x,
        &config->mu_y,  &config->resultant, &config->uncertainty, &config->forces, &config->status,
    };
    const bool has_forces = count == whole && config->forces.count;
    const result_t result = {beats + TFRA_HEADER_BEATS, &config->forces, has_forces ? 0u : config->forces.count};
    if (count && beats[count - 1] == TFRA_FRAME_CUT)
        return TFRA_ERROR_FRAME_ABORTED;
    if (count != whole - result.skipped)
        return TFRA_ERROR_FRAME_LENGTH;
    if (HEADER(beats, FORMAT) != TFRA_FRAME_FORMAT)
        return TFRA_ERROR_FRAME_FORMAT;
    for (size_t place = 0; place < sizeof fields / sizeof fields[0]; place++)
        if (!is_extended(&result, fields[place]))
            return TFRA_ERROR_FRAME_FORMAT;
    frame->sequence = HEADER(beats, SEQUENCE);
    frame->user = HEADER(beats, USER);
    frame->faults = HEADER(beats, FAULTS);
    frame->frame = word_of(&result, &config->frame);
    frame->exponent = word_of(&result, &config->exponent);
    frame->sweep_index = word_of(&result, &config->sweep_index);
    frame->phi = word_of(&result, &config->phi);
    frame->mu = signed_of(&result, &config->mu);
    frame->mu_x = signed_of(&result, &config->mu_x);
    frame->mu_y = signed_of(&result, &config->mu_y);
    for (uint32_t axis = 0; axis < 3; axis++)
        frame->resultant[axis] = ((const int32_t *)words_of(&result, &config->resultant))[axis];
    frame->uncertainty = signed_of(&result, &config->uncertainty);
    frame->status = word_of(&result, &config->status);
    frame->forces = has_forces ? (const int32_t *)words_of(&result, &config->forces) : NULL;
    return TFRA_OK;
}
