/** Channels in as few questions to the hub as an address may be long. Pure. */

/** Letters of the names in one question, and names: the hub takes so many. */
const MOST_LETTERS = 4000;
const MOST_NAMES = 100;

export function channelGroups(channels: readonly string[]): readonly (readonly string[])[] {
  const groups: string[][] = [];
  let letters = Infinity;
  for (const channel of channels) {
    let group = groups.at(-1);
    if (group === undefined || letters + channel.length > MOST_LETTERS || group.length === MOST_NAMES) {
      group = [];
      groups.push(group);
      letters = 0;
    }
    group.push(channel);
    letters += channel.length;
  }
  return groups;
}
