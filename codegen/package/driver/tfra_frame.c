/** @file tfra_frame.c
 *  Takes output frames of a TFRA core apart; tfra_driver.h describes the functions.  No access to the core.
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

/** Takes the header of an output frame with a version of its format apart; its `count` beats are more than those. */
static tfra_error_t parse_header(const uint32_t *beats, size_t count, uint32_t format, tfra_frame_t *frame)
{
    if (count && beats[count - 1] == TFRA_FRAME_CUT)
        return TFRA_ERROR_FRAME_ABORTED;
    if (count <= TFRA_HEADER_BEATS)
        return TFRA_ERROR_FRAME_LENGTH;
    if (HEADER(beats, FORMAT) != format)
        return TFRA_ERROR_FRAME_FORMAT;
    frame->sequence = HEADER(beats, SEQUENCE);
    frame->user = HEADER(beats, USER);
    frame->faults = HEADER(beats, FAULTS);
    return TFRA_OK;
}

/** Takes the words of a result apart, which has the forces at the taxels or not. */
static tfra_error_t parse_result(const tfra_config_t *config, const uint32_t *words, bool has_forces,
                                 tfra_frame_t *frame)
{
    const tfra_field_t *const fields[] = {
        &config->frame, &config->exponent, &config->sweep_index, &config->phi,    &config->mu,    &config->mu_x,
        &config->mu_y,  &config->resultant, &config->uncertainty, &config->forces, &config->status,
    };
    const result_t result = {words, &config->forces, has_forces ? 0u : config->forces.count};
    for (size_t place = 0; place < sizeof fields / sizeof fields[0]; place++)
        if (!is_extended(&result, fields[place]))
            return TFRA_ERROR_FRAME_FORMAT;
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

tfra_error_t tfra_parse_frame(const tfra_config_t *config, const uint32_t *beats, size_t count, tfra_frame_t *frame)
{
    const size_t whole = (size_t)TFRA_HEADER_BEATS + config->words;
    const bool has_forces = count == whole && config->forces.count;
    const tfra_error_t error = parse_header(beats, count, TFRA_FRAME_FORMAT, frame);
    if (error != TFRA_OK)
        return error;
    if (count != whole - (has_forces ? 0u : config->forces.count))
        return TFRA_ERROR_FRAME_LENGTH;
    return parse_result(config, beats + TFRA_HEADER_BEATS, has_forces, frame);
}

/** Whether the words of a frame are records of `size` words: they have its number, theirs, and one of them is the last. */
static bool are_records(const uint32_t *words, size_t count, size_t size)
{
    const size_t records = count / size;
    if (count % size || records > TFRA_CONTACTS_MOST)
        return false;
    for (size_t number = 0; number < records; number++) {
        const uint32_t *const record = words + number * size;
        if (record[TFRA_RECORD__FRAME] != words[TFRA_RECORD__FRAME] || record[TFRA_RECORD__CONTACT] != number ||
            record[TFRA_RECORD__LAST] != (number + 1u == records))
            return false;
    }
    return true;
}

tfra_error_t tfra_parse_contacts(const tfra_config_t *config, const uint32_t *beats, size_t count,
                                 tfra_skin_frame_t *frame, tfra_contact_t *contacts)
{
    const size_t whole = (size_t)config->record_words + config->words;
    const uint32_t *const words = beats + TFRA_HEADER_BEATS;
    tfra_frame_t header;
    if (!config->record_words)
        return TFRA_ERROR_ARGUMENT;
    const tfra_error_t error = parse_header(beats, count, TFRA_RECORDS_FORMAT, &header);
    if (error != TFRA_OK)
        return error;
    const size_t length = count - TFRA_HEADER_BEATS;
    const bool has_forces = config->forces.count && are_records(words, length, whole);
    const size_t size = has_forces ? whole : whole - config->forces.count;
    if (!are_records(words, length, size))
        return TFRA_ERROR_FRAME_LENGTH;
    const size_t records = length / size;
    const bool is_empty = words[TFRA_RECORD__TAXELS] == 0u;
    frame->sequence = header.sequence;
    frame->user = header.user;
    frame->faults = header.faults;
    frame->frame = words[TFRA_RECORD__FRAME];
    frame->dropped = words[(records - 1u) * size + TFRA_RECORD__DROPPED];
    frame->contacts = is_empty ? 0u : records;
    for (size_t number = 0; number < frame->contacts; number++) {
        const uint32_t *const record = words + number * size;
        tfra_contact_t *const contact = &contacts[number];
        contact->row = record[TFRA_RECORD__ROW];
        contact->column = record[TFRA_RECORD__COLUMN];
        contact->taxels = record[TFRA_RECORD__TAXELS];
        contact->marks = record[TFRA_RECORD__MARKS];
        contact->window = header;
        const tfra_error_t wrong = parse_result(config, record + config->record_words, has_forces, &contact->window);
        if (wrong != TFRA_OK)
            return wrong;
        contact->window.frame = frame->frame;
    }
    return TFRA_OK;
}
