export function plainTexts(strings: readonly string[]): string[];
