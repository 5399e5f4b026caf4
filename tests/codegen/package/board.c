/* A board whose registers are a file's words in memory, and whose frames come from others: for the example. */
#include <stdint.h>
#include <stdio.h>

void *board_registers(void);
size_t board_receive(uint32_t *beats, size_t most);

void *board_registers(void)
{
    static uint32_t words[1024];
    FILE *const file = fopen("registers.bin", "rb");
    if (!file || fread(words, 1, sizeof words, file) != sizeof words)
        return NULL;
    fclose(file);
    return words;
}

size_t board_receive(uint32_t *beats, size_t most)
{
    static FILE *file, *lengths;
    uint32_t count;
    if (!file) {
        file = fopen("frames.bin", "rb");
        lengths = fopen("lengths.bin", "rb");
    }
    return file && lengths && fread(&count, sizeof count, 1, lengths) && count <= most
               ? fread(beats, sizeof *beats, count, file)
               : 0;
}
