//! Keys in an open list or menu.

use egui::{Event, EventFilter, Key, Response, Ui};

/// Lets keys choose among the entries of an open list: arrows go to the next one, a letter to the next one that begins
/// with it, and Enter takes it. The list opens at `present`. Returns the entry that was taken.
pub(super) fn choose_by_keys(ui: &Ui, entries: &[(Response, &str)], present: usize) -> Option<usize> {
    // The entry that had the focus loses it to a click.
    if let Some(taken) = entries.iter().position(|(entry, _)| entry.clicked()) {
        ui.close();
        return Some(taken);
    }
    let Some(focused) = entries.iter().position(|(entry, _)| entry.has_focus()) else {
        entries.get(present).or(entries.first())?.0.request_focus();
        return None;
    };
    let (entry, _) = &entries[focused];
    // Arrows would leave the list.
    let filter = EventFilter { vertical_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(entry.id, filter));
    let is_pressed = |key| ui.input(|input| input.key_pressed(key));
    let count = entries.len();
    let begins = |index: &usize, letter: &str| entries[*index].1.to_lowercase().starts_with(letter);
    let typed = ui.input(|input| {
        input
            .events
            .iter()
            .find_map(|event| if let Event::Text(text) = event { Some(text.to_lowercase()) } else { None })
    });
    let next = match typed {
        _ if is_pressed(Key::ArrowDown) => Some((focused + 1).min(count - 1)),
        _ if is_pressed(Key::ArrowUp) => Some(focused.saturating_sub(1)),
        Some(letter) => (1..=count).map(|step| (focused + step) % count).find(|index| begins(index, &letter)),
        None => None,
    };
    if let Some(next) = next {
        entries[next].0.request_focus();
        entries[next].0.scroll_to_me(None);
    }
    None
}
