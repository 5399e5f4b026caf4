
// The front end: words of the converters become codes.  Members may be changed between frames.
typedef struct {
    uint8_t word_bits;     // bits of a word that are used, from 8 on; the others should be equal to the sign, or 0
    uint8_t is_unsigned;   // words are unsigned, not two's complement
    uint8_t invert;        // compression is positive
    uint8_t log2_average;  // frames of a mean, 6 at most
    uint8_t log2_tare;     // frames of a tare, 6 at most
    uint8_t stuck_frames;  // a word that is the same in so many frames is stuck; 0: never
    uint8_t check_sequence; // frames have numbers
    uint16_t dead_band;    // smaller codes become 0
    uint16_t contact;      // a frame whose codes are all smaller becomes 0
    int32_t offsets[${NAME}_TAXELS]; // in 1/2^17 of the converter's range
    uint32_t gains[${NAME}_TAXELS];  // 32768 is 1; 0 silences a taxel, and its faults
    const uint32_t *repairs; // a header, bit 31 set, has the taxel to replace in bits 30 to 18; each word after it has a
    uint16_t repair_words;   // source there, and its weight in bits 17 to 0, signed, in 1/65536
    // Private from here.
    int32_t sums[${NAME}_TAXELS];
    uint16_t words[${NAME}_TAXELS];
    uint8_t ages[${NAME}_TAXELS];
    uint16_t number;
    uint8_t seen;
    uint8_t numbered;
    uint8_t taring;
    uint8_t averaged;
} ${name}_front_end;

// Faults of a taxel's word, and of a frame.
enum {
    ${NAME}_SATURATION = 1,
    ${NAME}_OUT_OF_RANGE = 2,
    ${NAME}_STUCK = 4,
    ${NAME}_SEQUENCE_GAP = 8
};

// Settings, offsets and gains as after a reset of the gateware: offsets 0, gains 1, no repairs.
void ${name}_front_end_init(${name}_front_end *front_end);

// The mean of the next frames becomes the offsets.
void ${name}_front_end_tare(${name}_front_end *front_end);

// Take a frame of words with its number.  Returns 1 and gives codes if a mean is complete, else 0.  faults: bits of all
// frames of the mean.
int ${name}_front_end_step(${name}_front_end *front_end, const uint16_t words[${NAME}_TAXELS], uint16_t number,
    ${name}_code codes[${NAME}_TAXELS], uint8_t *faults);
