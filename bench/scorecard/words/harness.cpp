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

int main(int, char **arguments)
{
    if (!load(arguments[1]))
        return 2;
    const u64 seed = std::strtoull(arguments[2], nullptr, 10);
    const std::vector<int> given = items<int>(arguments[4]);
    const i64 directed = (i64)given.size() / TAXELS, frames = directed + std::atoll(arguments[3]);
    FILE *sample = std::fopen(arguments[5], "wb");
    Random random{seed};
    Exchange exchange{{{seed + 1}}, {{seed + 2}}};
    Ports ports;
    std::deque<Frame> due;
    Frame sending{-1, std::vector<CODE>(TAXELS), {}};
    bool begun = false;
    i64 drawn = 0, words = 0, differ = 0, broken = 0, cycles = 0, first = -1, drained = 0;
    reset(ports);
    ports.begin(items<unsigned>("coefficients"));
    std::printf("{");
    while (drained < 256 && exchange.quiet < PATIENCE) {
        if (!begun && drawn < frames) {
            begun = true;
            sending.number = drawn++;
            sending.words.clear();
            const int *codes = given.data() + sending.number * TAXELS;
            if (sending.number < directed)
                sending.codes.assign(codes, codes + TAXELS);
            else
                draw(random, sending.codes);
            expect(sending);
            due.push_back(sending);
            if (sending.number % 64 == 0) {
                exchange.in.choose();
                exchange.out.choose();
            }
            if (sending.number < directed || sending.number % STRIDE == 0) {
                const i64 count = (i64)sending.words.size();
                const std::vector<int> wide(sending.codes.begin(), sending.codes.end());
                std::fwrite(wide.data(), sizeof(int), wide.size(), sample);
                std::fwrite(&count, sizeof count, 1, sample);
                std::fwrite(sending.words.data(), sizeof(u64), sending.words.size(), sample);
            }
        }
        const size_t place = exchange.place;
        broken += exchange.cycle(ports, begun ? &sending : nullptr, due.empty() ? nullptr : &due.front());
        cycles++;
        begun &= !exchange.sent;
        drained = due.empty() && drawn == frames && !begun ? drained + 1 : 0;
        if (exchange.moved) {
            const Frame &frame = due.front();
            words++;
            if (exchange.word != frame.words[place] && !differ++) {
                first = frame.number;
                print("codes", frame.codes);
                std::printf("\"place\": %d, \"expected\": %llu, \"got\": %llu, ", (int)place, frame.words[place],
                            exchange.word);
            }
        }
        if (exchange.ended)
            due.pop_front();
    }
#if VM_COVERAGE
    ports.top.contextp()->coveragep()->write("coverage.dat");
#endif
    std::fclose(sample);
    std::printf("\"first\": %lld, \"frames\": %lld, \"words\": %lld, \"differ\": %lld, \"broken\": %lld, \"missing\": %d, "
                "\"cycles\": %lld}\n", first, frames, words, differ, broken, (int)due.size(), cycles);
    return 0;
}
