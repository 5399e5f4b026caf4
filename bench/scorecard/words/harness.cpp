// Frames through the Verilated core, and every word compared with that of the core in C.
//
// harness LIBRARY SEED FRAMES GIVEN SAMPLE: sends the codes of the file GIVEN, int32, then random FRAMES, with stalls on
// both ports, and writes what was compared as JSON.  The codes and the words of all given frames and of every STRIDE-th
// other one go into the file SAMPLE: codes as int32, the number of words and the words as int64.
#include "core.h"

static void print(const char *name, const std::vector<CODE> &codes)
{
    std::printf("\"%s\": [", name);
    for (size_t place = 0; place < codes.size(); place++)
        std::printf("%s%lld", place ? ", " : "", (i64)codes[place]);
    std::printf("], ");
}

static std::vector<char> bytes(const char *name)
{
    std::vector<char> found;
    if (FILE *file = std::fopen(name, "rb")) {
        for (int c; (c = std::fgetc(file)) != EOF;)
            found.push_back((char)c);
        std::fclose(file);
    }
    return found;
}

int main(int, char **arguments)
{
    void *library = dlopen(arguments[1], RTLD_NOW);
    if (!library)
        return std::fprintf(stderr, "%s\n", dlerror()), 2;
    run = (Run)dlsym(library, "run");
    const u64 seed = std::strtoull(arguments[2], nullptr, 10);
    const std::vector<char> given = bytes(arguments[4]), loaded = bytes("coefficients");
    const i64 directed = (i64)(given.size() / sizeof(int) / TAXELS), frames = directed + std::atoll(arguments[3]);
    FILE *sample = std::fopen(arguments[5], "wb");
    Random random{seed};
    Stalls in{{seed + 1}}, out{{seed + 2}};
    Ports ports;
    std::deque<Frame> due;
    Frame sending{-1, std::vector<CODE>(TAXELS), {}};
    int beat = Ports::beats;
    size_t place = 0;
    bool holding = false, waiting = false;
    u64 waited = 0;
    i64 sent = 0, words = 0, differ = 0, broken = 0, cycles = 0, quiet = 0, first = -1, drained = 0;
    ports.offer(false, sending.codes.data(), 0, 0);
    ports.take(false);
    ports.reset(1);
    for (int cycle = 0; cycle < 4; cycle++) {
        ports.clock(0);
        ports.clock(1);
    }
    ports.reset(0);
    ports.begin(std::vector<unsigned>((const unsigned *)loaded.data(), (const unsigned *)(loaded.data() + loaded.size())));
    std::printf("{");
    while (drained < 256 && quiet < PATIENCE) {
        if (beat == Ports::beats && sent < frames) {
            sending.number = sent++;
            sending.words.clear();
            const int *codes = (const int *)given.data() + sending.number * TAXELS;
            if (sending.number < directed)
                sending.codes.assign(codes, codes + TAXELS);
            else
                draw(random, sending.codes);
            expect(sending);
            due.push_back(sending);
            beat = 0;
            if (sending.number % 64 == 0) {
                in.choose();
                out.choose();
            }
            if (sending.number < directed || sending.number % STRIDE == 0) {
                const i64 count = (i64)sending.words.size();
                const std::vector<int> wide(sending.codes.begin(), sending.codes.end());
                std::fwrite(wide.data(), sizeof(int), wide.size(), sample);
                std::fwrite(&count, sizeof count, 1, sample);
                std::fwrite(sending.words.data(), sizeof(u64), sending.words.size(), sample);
            }
        }
        const bool offered = beat < Ports::beats && (holding || !in.now());
        const bool ready = due.empty() || !out.now();
        ports.offer(offered, sending.codes.data(), beat < Ports::beats ? beat : 0, sending.number);
        ports.take(ready);
        ports.clock(0);
        const bool valid = ports.valid(), taken = offered && ports.ready();
        const u64 word = valid ? ports.word() : 0;
        const bool last = valid && ports.last();
        broken += waiting && (!valid || word != waited);
        ports.clock(1);
        cycles++;
        beat += taken;
        holding = offered && !taken;
        waiting = valid && !ready;
        waited = word;
        quiet = taken || (valid && ready) ? 0 : quiet + 1;
        drained = due.empty() && sent == frames && beat == Ports::beats ? drained + 1 : 0;
        if (due.empty()) {
            broken += valid;
        } else if (valid && ready) {
            Frame &frame = due.front();
            const size_t record = Ports::head + RECORD_WORDS;
            broken += last != (place % record == record - 1);
            words++;
            if (word != frame.words[place] && !differ++) {
                first = frame.number;
                print("codes", frame.codes);
                std::printf("\"place\": %d, \"expected\": %llu, \"got\": %llu, ", (int)place, frame.words[place], word);
            }
            if (++place == frame.words.size()) {
                due.pop_front();
                place = 0;
            }
        }
    }
#if VM_COVERAGE
    ports.top.contextp()->coveragep()->write("coverage.dat");
#endif
    std::fclose(sample);
    std::printf("\"first\": %lld, \"frames\": %lld, \"words\": %lld, \"differ\": %lld, \"broken\": %lld, \"missing\": %d, "
                "\"cycles\": %lld}\n", first, frames, words, differ, broken, (int)due.size(), cycles);
    return 0;
}
