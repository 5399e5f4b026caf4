// Sends the frames of tb_data/tb_input_features.dat, and compares with the words of tb_data/tb_output_predictions.dat:
// prints the first that differs, and returns 1 then.  All words are written to tb_data/csim_results.log.
#include "firmware/$name.h"

#include <cstdio>
#include <fstream>

enum { TAXELS = $taxels, WORDS = $words };

static const struct {
    int first;
    const char *name;
} fields[] = {
$names
};

static const char *field_of(int word)
{
    const char *name = "";
    for (const auto &field : fields)
        if (field.first <= word)
            name = field.name;
    return name;
}

int main()
{
    std::ifstream given("tb_data/tb_input_features.dat"), expected("tb_data/tb_output_predictions.dat");
    std::ofstream log("tb_data/csim_results.log");
    hls::stream<beat_t> codes("codes"), words("words");
    ap_uint<32> misplaced = 0;
    long long frame = 0, code = 0, right = 0;
    for (; given >> code; frame++) {
        for (int taxel = 0; taxel < TAXELS; taxel++) {
            beat_t beat;
            beat.data = code;
            beat.keep = -1;
            beat.strb = -1;
            beat.last = taxel == TAXELS - 1;
            codes.write(beat);
            if (!beat.last)
                given >> code;
        }
        $name(codes, words, misplaced);
        for (int word = 0; word < WORDS; word++) {
            const beat_t beat = words.read();
            const long long value = beat.data.to_int64();
            log << value << (word == WORDS - 1 ? "\n" : " ");
            expected >> right;
            if (!expected || value != right) {
                std::printf("frame %lld, word %d, %s: %lld, %lld is right\n", frame, word, field_of(word), value, right);
                return 1;
            }
            if (beat.last != (word == WORDS - 1)) {
                std::printf("frame %lld, word %d: TLAST is %d\n", frame, word, (int)beat.last);
                return 1;
            }
        }
    }
    if (frame == 0 || misplaced != 0) {
        std::printf("%lld frames, %u of them without TLAST on their last code\n", frame, (unsigned)misplaced);
        return 1;
    }
    std::printf("$name: %lld frames, %lld words, all right\n", frame, frame * WORDS);
    return 0;
}
