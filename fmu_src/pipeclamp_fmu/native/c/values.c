/* Reading the file of values: a line each, a name and a number as the 16 hexadecimal digits of its bits.
 *
 * So the numbers are exact and don't depend on the host's language, which decides how `strtod` reads "0.5". What
 * follows the digits on a line is for people.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN /* for MultiByteToWideChar alone; the rest takes names such as FIXED */
#define NOGDI
#include <windows.h>
#endif

#include "values.h"

static const char FILE_NAME[] = "values.txt";
enum { PATH_LENGTH = 4096, LINE = 1024 };

#ifdef _WIN32
/* Slashes become backslashes, which a path that begins with \\?\ must have. */
static FILE *opened_in(UINT code_page, const char *path)
{
    wchar_t wide[PATH_LENGTH], *at;
    const DWORD strict = code_page == CP_UTF8 ? MB_ERR_INVALID_CHARS : 0;
    if (!MultiByteToWideChar(code_page, strict, path, -1, wide, PATH_LENGTH))
        return NULL;
    for (at = wide; *at; at++)
        if (*at == L'/')
            *at = L'\\';
    return _wfopen(wide, L"rb");
}
#endif

static FILE *opened(const char *folder)
{
    char path[PATH_LENGTH];
    const size_t length = strlen(folder);
    const char *separator = length > 0 && (folder[length - 1] == '/' || folder[length - 1] == '\\') ? "" : "/";
    if (snprintf(path, sizeof path, "%s%s%s", folder, separator, FILE_NAME) >= (int)sizeof path)
        return NULL;
#ifdef _WIN32
    {
        FILE *const file = opened_in(CP_UTF8, path); /* as both standards say; some tools give their own code page */
        return file ? file : opened_in(CP_ACP, path);
    }
#else
    return fopen(path, "rb");
#endif
}

static void skip_line(FILE *file)
{
    int character;
    do
        character = fgetc(file);
    while (character != '\n' && character != EOF);
}

/* Give what follows the expected name on the next line, cut off where that is long, or say that it isn't there. */
static char *after_name(FILE *file, const char *name, char line[LINE], char reason[TEXT])
{
    const size_t length = strlen(name);
    if (fgets(line, LINE, file) && strncmp(line, name, length) == 0 && line[length] == ' ') {
        if (!strchr(line, '\n'))
            skip_line(file);
        line[strcspn(line, "\r\n")] = '\0';
        return line + length + 1;
    }
    snprintf(reason, TEXT, "resources/%s: expected %s", FILE_NAME, name);
    return NULL;
}

static int number(FILE *file, const char *name, double *value, char reason[TEXT])
{
    char line[LINE], *end;
    const char *digits = after_name(file, name, line, reason);
    uint64_t bits;
    if (!digits)
        return 0;
    bits = strtoull(digits, &end, 16);
    if (end - digits != 16) {
        snprintf(reason, TEXT, "resources/%s: expected 16 hexadecimal digits after %s", FILE_NAME, name);
        return 0;
    }
    memcpy(value, &bits, sizeof *value);
    return 1;
}

/* Give how many bytes of a text (UTF-8) fit into a room without parting a character. */
static int whole_characters(const char *text, size_t room)
{
    size_t length = strlen(text);
    if (length > room)
        for (length = room; length > 0 && (text[length] & 0xC0) == 0x80;)
            length--;
    return (int)length;
}

static int read_all(FILE *file, Values *values, const char *token, char reason[TEXT])
{
    char line[LINE];
    const char *text;
    int i;
    if (!(text = after_name(file, "token", line, reason)))
        return 0;
    if (strcmp(text, token) != 0) {
        snprintf(reason, TEXT, "the FMU is %.64s, and its model description was read as %.64s", text, token);
        return 0;
    }
    if (!(text = after_name(file, "name", line, reason)))
        return 0;
    snprintf(values->name, sizeof values->name, "%.*s", whole_characters(text, sizeof values->name - 1), text);
    for (i = 0; i < INPUTS + PARAMETERS; i++)
        if (!number(file, REAL_NAMES[i], &values->start[i], reason))
            return 0;
    for (i = 0; i < FIXED; i++)
        if (!number(file, REAL_NAMES[FIRST_FIXED + i], &values->fixed[i], reason))
            return 0;
    for (i = 0; i < FLAG_PARAMETERS; i++) {
        double value;
        if (!number(file, FLAG_NAMES[i], &value, reason))
            return 0;
        values->flag[i] = value != 0.0;
    }
    for (i = 0; i < RANGES; i++)
        if (!number(file, "minimum", &values->range[i][0], reason)
            || !number(file, "maximum", &values->range[i][1], reason))
            return 0;
    return 1;
}

static int values_read(Values *values, const char *folder, const char *token, char reason[TEXT])
{
    FILE *file = folder ? opened(folder) : NULL;
    int done;
    if (!file) {
        snprintf(reason, TEXT, "resources/%s can't be read in %.300s", FILE_NAME, folder ? folder : "no folder");
        return 0;
    }
    memset(values, 0, sizeof *values);
    done = read_all(file, values, token, reason);
    fclose(file);
    return done;
}
