/* A board whose registers are a file's words in memory, and whose frames come from another: for the example. */
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
    static FILE *file;
    if (!file)
        file = fopen("frames.bin", "rb");
    return file && FRAME <= most ? fread(beats, sizeof *beats, FRAME, file) : 0;
}
