// Block-floating input: a frame is shifted so that its largest code fills the word, and keeps its exponent.

typedef struct {
    int exponent;          // stress is code * 2^exponent
    wide_t magnitude;      // sum of |stress| (Eq. 29)
    bool contact;          // a code is negative, and one reaches the contact threshold
    bool regular;          // both compression and traction: only such frames are swept
    bool saturated;        // a code is at an end of its range
} frame_t;

static void normaliser(const code_t codes[TAXELS], code_t stress[TAXELS], frame_t *frame)
{
    const int top = (1 << (ADC_BITS - 1)) - 1;
    int needed = 0, lowest = 0, highest = 0;
    for (int t = 0; t < TAXELS; t++) {
        const int code = codes[t];
        needed |= code ^ (code >> 31);
        lowest = code < lowest ? code : lowest;
        highest = code > highest ? code : highest;
    }
    frame->exponent = ADC_BITS - 1 - bit_length(needed);
    const int factor = 1 << frame->exponent; //+ const unsigned exponent = (unsigned)frame->exponent;
    magnitude_t sum = 0;
    for (int t = 0; t < TAXELS; t++) {
        const int word = codes[t] * factor; //+ const int word = (int)((wide_t)codes[t] << exponent);
        stress[t] = (code_t)word;
        sum += word < 0 ? -word : word;
    }
    frame->magnitude = sum;
    frame->contact = lowest < 0 && (lowest < -CONTACT_THRESHOLD || highest >= CONTACT_THRESHOLD);
    frame->regular = frame->contact && highest > 0;
    frame->saturated = highest >= top || lowest <= -top - 1;
}
