// The front end: words of the converters become codes.

#define CONVERTER 16 // bits of a converter's word
#define DEVIATION 18 // bits of a mean less its offset, in 1/2^17 of the range
#define PRODUCT_POINT 32
#define WEIGHT_ONE 16 // fraction bits of a repair's weight

void ${name}_front_end_init(${name}_front_end *front_end)
{
    memset(front_end, 0, sizeof *front_end);
    front_end->word_bits = ADC_BITS;
    for (int t = 0; t < TAXELS; t++)
        front_end->gains[t] = 1u << 15;
}

static void start_mean(${name}_front_end *front_end)
{
    memset(front_end->sums, 0, sizeof front_end->sums);
    front_end->averaged = 0;
    front_end->seen = 0;
}

void ${name}_front_end_tare(${name}_front_end *front_end)
{
    front_end->taring = 1;
    start_mean(front_end);
}

// The value of a word, and its faults.
static int32_t converted(${name}_front_end *front_end, int taxel, uint16_t word, uint8_t *faults)
{
    const int bits = front_end->word_bits;
    const int32_t half = (int32_t)1 << (bits - 1);
    int32_t value = word & (2 * half - 1);
    int32_t lowest = 0;
    if (!front_end->is_unsigned) {
        value = (value ^ half) - half;
        lowest = -half;
    }
    uint8_t found = 0;
    if (value == lowest || value == lowest + 2 * half - 1)
        found |= ${NAME}_SATURATION;
    if ((uint16_t)value != word)
        found |= ${NAME}_OUT_OF_RANGE;
    if (front_end->ages[taxel] == 0 || word != front_end->words[taxel])
        front_end->ages[taxel] = 1;
    else if (front_end->ages[taxel] < UINT8_MAX)
        front_end->ages[taxel] = (uint8_t)(front_end->ages[taxel] + 1);
    front_end->words[taxel] = word;
    if (front_end->stuck_frames > 0 && front_end->ages[taxel] >= front_end->stuck_frames)
        found |= ${NAME}_STUCK;
    if (front_end->gains[taxel] > 0)
        *faults |= found;
    return value * ((int32_t)1 << (CONVERTER - bits));
}

// Codes after the repairs in their order; returns the largest magnitude that was written.
static int32_t repaired(const ${name}_front_end *front_end, code_t codes[TAXELS])
{
    int32_t largest = 0;
    int place = 0;
    while (place < front_end->repair_words && !(front_end->repairs[place] >> 31))
        place++;
    while (place < front_end->repair_words) {
        const uint32_t taxel = (front_end->repairs[place] & 0x7fffffffu) >> 18;
        int64_t sum = 0;
        for (place++; place < front_end->repair_words && !(front_end->repairs[place] >> 31); place++) {
            const uint32_t source = front_end->repairs[place] >> 18;
            const int32_t weight = (int32_t)((front_end->repairs[place] & 0x3ffffu) ^ 0x20000u) - 0x20000;
            if (source < TAXELS)
                sum += (int64_t)weight * codes[source];
        }
        const wide_t code = saturate(round_shift(sum, WEIGHT_ONE), ADC_BITS);
        if (taxel < TAXELS)
            codes[taxel] = (code_t)code;
        if (magnitude(code) > largest)
            largest = (int32_t)magnitude(code);
    }
    return largest;
}

int ${name}_front_end_step(${name}_front_end *front_end, const uint16_t words[TAXELS], uint16_t number,
    code_t codes[TAXELS], uint8_t *faults)
{
    if (!front_end->check_sequence)
        front_end->numbered = 0;
    else if (front_end->numbered && (uint16_t)(number - front_end->number) != 1)
        front_end->seen |= ${NAME}_SEQUENCE_GAP;
    if (front_end->check_sequence)
        front_end->numbered = 1;
    front_end->number = number;
    for (int t = 0; t < TAXELS; t++)
        front_end->sums[t] += converted(front_end, t, words[t], &front_end->seen);

    const int frames = front_end->taring ? front_end->log2_tare : front_end->log2_average;
    front_end->averaged++;
    if ((front_end->averaged & ((1u << frames) - 1)) != 0)
        return 0;
    if (front_end->taring) {
        for (int t = 0; t < TAXELS; t++)
            front_end->offsets[t] = (int32_t)round_shift(2 * (wide_t)front_end->sums[t], frames);
        front_end->taring = 0;
        start_mean(front_end);
        return 0;
    }
    int32_t largest = 0;
    for (int t = 0; t < TAXELS; t++) {
        const wide_t mean = round_shift(2 * (wide_t)front_end->sums[t], frames);
        const wide_t deviation = saturate(mean - front_end->offsets[t], DEVIATION);
        const wide_t gain = front_end->invert ? -(wide_t)front_end->gains[t] : (wide_t)front_end->gains[t];
        const wide_t code = saturate(round_shift(deviation * gain, PRODUCT_POINT - ADC_BITS), ADC_BITS);
        codes[t] = (code_t)code;
        if (magnitude(code) > largest)
            largest = (int32_t)magnitude(code);
    }
    const int32_t written = repaired(front_end, codes);
    if (written > largest)
        largest = written;
    for (int t = 0; t < TAXELS; t++)
        if (largest < front_end->contact || magnitude(codes[t]) < front_end->dead_band)
            codes[t] = 0;
    *faults = front_end->seen;
    start_mean(front_end);
    return 1;
}
