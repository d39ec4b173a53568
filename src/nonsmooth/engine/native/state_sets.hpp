// Sets of coordinates: a bit for each, in as many words as the largest system needs.
//
// Which states a mode slaves or an exit resets is asked at every event, so a set is a value of a
// fixed size beside the other numbers of its mode, not a list of its own.
#pragma once

#include <stdint.h>

#include <bit>

#include "records.hpp"

namespace nonsmooth {

inline bool has_bit(const StateSet& set, Index i) { return (set.words[i >> 6] >> (i & 63)) & 1; }

// Members of a set below a count, in order: words are few, and most sets have no member at all.
class Members {
  public:
    Members(const StateSet& set, Index count) : set_(set), n_words_((count + 63) >> 6) {}

    struct Place {
        const StateSet& set;
        Index n_words, word;
        uint64_t left;  // in this word

        void skip_empty() {
            while (left == 0 && ++word < n_words) left = set.words[word];
        }
        Index operator*() const { return (word << 6) + std::countr_zero(left); }
        bool operator!=(Index) const { return word < n_words; }
        void operator++() {
            left &= left - 1;
            skip_empty();
        }
    };

    Place begin() const {
        Place first{set_, n_words_, 0, set_.words[0]};
        first.skip_empty();
        return first;
    }
    Index end() const { return n_words_; }

  private:
    const StateSet& set_;
    const Index n_words_;
};

inline void insert(StateSet& set, Index i) { set.words[i >> 6] |= uint64_t{1} << (i & 63); }

inline bool is_empty(const StateSet& set) {
    uint64_t any = 0;
    for (const uint64_t word : set.words) any |= word;
    return any == 0;
}

inline Index count_bits(const StateSet& set) {
    Index count = 0;
    for (const uint64_t word : set.words) count += std::popcount(word);
    return count;
}

inline void unite(StateSet& set, const StateSet& other) {
    for (Index k = 0; k < SET_WORDS; ++k) set.words[k] |= other.words[k];
}

// What is in both.
inline StateSet in_both(const StateSet& one, const StateSet& other) {
    StateSet both;
    for (Index k = 0; k < SET_WORDS; ++k) both.words[k] = one.words[k] & other.words[k];
    return both;
}

// What is in a set and not in the other.
inline StateSet without(const StateSet& set, const StateSet& other) {
    StateSet rest;
    for (Index k = 0; k < SET_WORDS; ++k) rest.words[k] = set.words[k] & ~other.words[k];
    return rest;
}

// Slaved states of a mode that are given by expressions.
inline StateSet explicitly_slaved(const Tables& tables, Index m) {
    return without(mode_wiring(tables, m).slaved, mode_wiring(tables, m).implicit);
}

}  // namespace nonsmooth
